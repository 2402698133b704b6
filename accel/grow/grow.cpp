// Eager growth, depth first, left before right.
#include "accel/grow/grow.h"

#include <algorithm>
#include <bit>

#include "accel/grow/clip_straddlers.h"
#include "accel/grow/fork.h"
#include "accel/grow/list_stack.h"
#include "accel/grow/small_subtree.h"
#include "accel/kdtree/sift.h"
#include "accel/split/reference_budget.h"

namespace sightline::accel::grow {
namespace {

using BoxStack = ListStack<kdtree::BoxRef>;

class Growth {
 public:
  explicit Growth(const GrowContext& context)
      : context_(context), rule_(context.rule), small_(context.rule.small_rule()) {}

  /// `first`: what the first pass over the list would find, or null.
  kdtree::Slot grow(std::span<kdtree::BoxRef> refs, const geometry::Aabb& cell,
                    const kdtree::CellPath& path, const kdtree::FirstScan* first, BoxStack& lists,
                    kdtree::BuildCounters& counters) {
    if (refs.size() >= kForkFrom && context_.cancelled != nullptr &&
        context_.cancelled->load(std::memory_order_relaxed)) {
      return defer(refs, cell, path, false);
    }
    if (small_ && is_small(refs)) return grow_small(context_, *small_, refs, cell, path, counters);
    const std::optional<kdtree::Cut> cut =
        path.depth < context_.max_depth ? choose(refs, cell, path, first, counters) : std::nullopt;
    if (!cut) return leaf(refs, cell, path);
    const kdtree::Plane& plane = cut->plane;

    // Before the list is divided: without room for the children it stays as it is.
    const std::optional<std::uint32_t> pair = context_.tree.allocate_pair();
    if (!pair) return defer(refs, cell, path, true);

    const geometry::HalvedCell halves = halve(cell, plane.axis, plane.position);
    const BoxStack::Mark mark = lists.mark();
    kdtree::BoxRef* right = lists.top(refs.size());
    std::optional<split::FirstScans> scans;
    kdtree::Sifted n = divide(refs, *cut, halves, right, scans);
    counters.touches += refs.size();
    if (n.left == refs.size() && n.right == refs.size())
      return leaf(refs, cell, path);  // separates nothing
    const std::size_t straddlers = n.left + n.right - refs.size();
    if (!split::affords(path, straddlers)) {
      put_back({right, n.right}, plane, refs.subspan(n.left));
      return leaf(refs, cell, path);
    }
    if (context_.mesh != nullptr && rule_.clips(straddlers, refs.size())) {
      n.left = clip_straddlers(*context_.mesh, refs.first(n.left), plane, halves.left);
      n.right = clip_straddlers(*context_.mesh, {right, n.right}, plane, halves.right);
      scans.reset();  // of lists that are others now
    }
    lists.take(n.right);
    const kdtree::Slot slot = kdtree::Slot::binary(plane, *pair);
    kdtree::AtomicSlot* children = context_.tree.children(slot);
    const split::HalvedPath below =
        split::halve_path(split::cap_below_useless_cut(path, refs.size(), n.left, n.right), *cut,
                          halves, static_cast<double>(refs.size()), static_cast<double>(n.left),
                          static_cast<double>(n.right));
    const auto grow_left = [&] {
      set(children[0], grow(refs.first(n.left), halves.left, below.left,
                            scans ? &scans->left : nullptr, lists, counters));
    };
    const auto grow_right = [&](BoxStack& own, kdtree::BuildCounters& sum) {
      set(children[1], grow({right, n.right}, halves.right, below.right,
                            scans ? &scans->right : nullptr, own, sum));
    };
    if (std::min(n.left, n.right) >= kForkFrom) {
      kdtree::BuildCounters right_counters;
      fork(grow_left, [&] {
        BoxStack own;
        grow_right(own, right_counters);
      });
      counters += right_counters;
    } else {
      grow_left();
      grow_right(lists, counters);
    }
    lists.release(mark);
    return slot;
  }

 private:
  /// Not published until the slot of the whole subtree is.
  static void set(kdtree::AtomicSlot& slot, kdtree::Slot value) {
    slot.store(value.bits(), std::memory_order_relaxed);
  }

  /// Undoes a division: what went to the right alone goes behind the left list.
  static void put_back(std::span<const kdtree::BoxRef> right, const kdtree::Plane& plane,
                       std::span<kdtree::BoxRef> out) {
    const auto axis = static_cast<std::size_t>(plane.axis);
    std::copy_if(right.begin(), right.end(), out.begin(), [&](const kdtree::BoxRef& ref) {
      return !(ref.lo[axis] < plane.position && ref.hi[axis] > plane.position);
    });
  }

  std::optional<kdtree::Cut> choose(std::span<const kdtree::BoxRef> refs,
                                    const geometry::Aabb& cell, const kdtree::CellPath& path,
                                    const kdtree::FirstScan* first,
                                    kdtree::BuildCounters& counters) const {
    kdtree::CellRefs list{refs, cell, path};
    list.first = first;
    return rule_.choose(list, counters);
  }

  /// The left list over `refs`, the right one to `right`; counted meanwhile where that is of use.
  kdtree::Sifted divide(std::span<kdtree::BoxRef> refs, const kdtree::Cut& cut,
                        const geometry::HalvedCell& halves, kdtree::BoxRef* right,
                        std::optional<split::FirstScans>& scans) const {
    if (rule_.scans_children(refs.size())) {
      scans.emplace(split::FirstScans{
          rule_.first_planes(halves.left), rule_.first_planes(halves.right), {}, {}});
      return sift_and_scan(refs, cut.plane, refs.data(), right, *scans);
    }
    return kdtree::sift(refs, cut, refs.data(), right);
  }

  kdtree::Slot leaf(std::span<const kdtree::BoxRef> refs, const geometry::Aabb& cell,
                    const kdtree::CellPath& path) {
    const std::optional<kdtree::Slot> slot = context_.tree.make_leaf(refs);
    return slot ? *slot : defer(refs, cell, path, true);
  }

  kdtree::Slot defer(std::span<const kdtree::BoxRef> refs, const geometry::Aabb& box,
                     const kdtree::CellPath& path, bool given_up) {
    kdtree::BoxList list(refs.size());
    std::copy(refs.begin(), refs.end(), list.all().begin());
    return context_.tree.defer(std::move(list), box, path, given_up);
  }

  const GrowContext& context_;
  const split::SplitSearch& rule_;
  std::optional<split::BoundRule>
      small_;  ///< For all lists up to split::kSmallList, if there is one.
};

}  // namespace

int depth_limit(std::size_t references) {
  const auto log2 = static_cast<double>(std::bit_width(references));
  return std::min(static_cast<int>(8 + 1.3 * log2) + 20, kdtree::kMaxTreeDepth);
}

int depth_limit(const split::SplitSearch& rule, std::size_t references) {
  return std::min(depth_limit(references), rule.depth_bound(references));
}

kdtree::Slot grow(const GrowContext& context, std::span<kdtree::BoxRef> refs,
                  const geometry::Aabb& cell, const kdtree::CellPath& path,
                  kdtree::BuildCounters& counters) {
  if (const auto grown = context.rule.grow_subtree(context, refs, cell, path, counters))
    return *grown;
  BoxStack lists;
  return Growth(context).grow(refs, cell, path, nullptr, lists, counters);
}

}  // namespace sightline::accel::grow
