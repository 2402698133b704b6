// Eager growth, depth first, left before right.
#include "accel/grow/grow.h"

#include <algorithm>
#include <bit>

#include "accel/grow/cell_cut.h"
#include "accel/grow/fork.h"
#include "accel/grow/list_stack.h"
#include "accel/grow/small_subtree.h"

namespace sightline::accel::grow {
namespace {

using ReferenceStack = ListStack<kdtree::Reference>;

class Growth {
 public:
  explicit Growth(const GrowContext& context)
      : context_(context), rule_(context.rule), small_(context.rule.small_rule()) {}

  /// `first`: what the first pass over the list would find, or null.
  kdtree::Slot grow(std::span<kdtree::Reference> refs, const geometry::Aabb& cell,
                    const kdtree::CellPath& path, const kdtree::ChildScan* first,
                    ReferenceStack& lists, kdtree::BuildCounters& counters) {
    if (refs.size() >= kForkFrom && context_.cancelled != nullptr &&
        context_.cancelled->load(std::memory_order_relaxed)) {
      return defer(refs, cell, path, false);
    }
    if (small_ && is_small(refs)) return grow_small(context_, *small_, refs, cell, path, counters);
    const std::optional<kdtree::Split> cut =
        path.depth < context_.max_depth ? choose(refs, cell, path, first, counters) : std::nullopt;
    if (!cut) return leaf(refs, cell, path);

    // Before the list is divided: without room for the children it stays as it is.
    const std::optional<std::uint32_t> pair = context_.tree.allocate_pair();
    if (!pair) return defer(refs, cell, path, true);

    const CellCut sides(rule_, context_.mesh, cell, path, refs.size(), *cut);
    const ReferenceStack::Mark mark = lists.mark();
    kdtree::Reference* right = lists.top(refs.size());
    std::optional<split::ChildScans> scans = sides.first_scans();
    kdtree::PartitionCounts n = sides.sift(refs, refs.data(), right, scans);
    counters.touches += refs.size();
    const std::size_t straddlers = n.left + n.right - refs.size();
    if (!sides.is_made(straddlers)) {
      put_back({right, n.right}, cut->plane, refs.subspan(n.left));
      return leaf(refs, cell, path);
    }
    if (sides.clips(straddlers, refs.size())) {
      n = sides.clip(refs.first(n.left), {right, n.right});
      scans.reset();
    }
    lists.take(n.right);
    grow_children(sides, {refs.first(n.left), {right, n.right}}, scans,
                  context_.tree.children(kdtree::Slot::binary(cut->plane, *pair)), lists, counters);
    lists.release(mark);
    return kdtree::Slot::binary(cut->plane, *pair);
  }

 private:
  struct Lists {
    std::span<kdtree::Reference> left, right;
  };

  void grow_children(const CellCut& sides, const Lists& refs,
                     const std::optional<split::ChildScans>& scans, kdtree::AtomicSlot* children,
                     ReferenceStack& lists, kdtree::BuildCounters& counters) {
    const HalvedPath below = sides.paths({refs.left.size(), refs.right.size()});
    const auto grow_left = [&] {
      set(children[0], grow(refs.left, sides.halves().left, below.left,
                            scans ? &scans->left : nullptr, lists, counters));
    };
    const auto grow_right = [&](ReferenceStack& own, kdtree::BuildCounters& sum) {
      set(children[1], grow(refs.right, sides.halves().right, below.right,
                            scans ? &scans->right : nullptr, own, sum));
    };
    if (std::min(refs.left.size(), refs.right.size()) < kForkFrom) {
      grow_left();
      grow_right(lists, counters);
      return;
    }
    kdtree::BuildCounters right_counters;
    fork(grow_left, [&] {
      ReferenceStack own;
      grow_right(own, right_counters);
    });
    counters += right_counters;
  }

  /// Not published until the slot of the whole subtree is.
  static void set(kdtree::AtomicSlot& slot, kdtree::Slot value) {
    slot.store(value.bits(), std::memory_order_relaxed);
  }

  /// Undoes a division: what went to the right alone goes behind the left list.
  static void put_back(std::span<const kdtree::Reference> right, const kdtree::Plane& plane,
                       std::span<kdtree::Reference> out) {
    const auto axis = static_cast<std::size_t>(plane.axis);
    std::copy_if(right.begin(), right.end(), out.begin(), [&](const kdtree::Reference& ref) {
      return !(ref.lo[axis] < plane.position && ref.hi[axis] > plane.position);
    });
  }

  std::optional<kdtree::Split> choose(std::span<const kdtree::Reference> refs,
                                      const geometry::Aabb& cell, const kdtree::CellPath& path,
                                      const kdtree::ChildScan* first,
                                      kdtree::BuildCounters& counters) const {
    kdtree::CellRefs list{refs, cell, path};
    list.first = first;
    return rule_.choose(list, counters);
  }

  kdtree::Slot leaf(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                    const kdtree::CellPath& path) {
    const std::optional<kdtree::Slot> slot = context_.tree.make_leaf(refs);
    return slot ? *slot : defer(refs, cell, path, true);
  }

  kdtree::Slot defer(std::span<const kdtree::Reference> refs, const geometry::Aabb& box,
                     const kdtree::CellPath& path, bool failed) {
    kdtree::ReferenceList list(refs.size());
    std::copy(refs.begin(), refs.end(), list.all().begin());
    return context_.tree.defer(std::move(list), box, path, failed);
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

kdtree::Slot grow(const GrowContext& context, std::span<kdtree::Reference> refs,
                  const geometry::Aabb& cell, const kdtree::CellPath& path,
                  kdtree::BuildCounters& counters) {
  if (const auto grown = context.rule.grow_subtree(context, refs, cell, path, counters))
    return *grown;
  ReferenceStack lists;
  return Growth(context).grow(refs, cell, path, nullptr, lists, counters);
}

}  // namespace sightline::accel::grow
