// Eager growth, depth first, left before right.
#include "accel/build/grow.h"

#include <algorithm>
#include <bit>

#include <tbb/task_group.h>

#include "accel/build/clip_straddlers.h"
#include "accel/build/list_stack.h"
#include "accel/build/sift.h"

namespace sightline::accel {
namespace {

/// Subtrees over at least this many references are worth a task of their own.
constexpr std::size_t kTask = 4096;

template <class Builder>
class Growth {
 public:
  Growth(const GrowContext& context, const Builder& builder) : context_(context), builder_(builder) {}

  Slot grow(std::span<BoxRef> refs, const Aabb& cell, int depth, ListStack& lists, BuildCounters& counters) {
    if (refs.size() >= kTask && context_.cancelled != nullptr && context_.cancelled->load(std::memory_order_relaxed)) {
      return defer(refs, cell, depth, false);
    }
    const std::optional<Cut> cut =
        depth < context_.max_depth ? builder_.choose({refs, cell, depth}, counters) : std::nullopt;
    if (!cut) return leaf(refs, cell, depth);
    const Plane& plane = cut->plane;

    // Before the list is divided: without room for the children it stays as it is.
    const std::optional<std::uint32_t> pair = context_.tree.allocate_pair();
    if (!pair) return defer(refs, cell, depth, true);

    const HalvedCell halves = halve(cell, plane.axis, plane.position);
    const ListStack::Mark mark = lists.mark();
    BoxRef* right = lists.top(refs.size());
    Sifted n = sift(refs, *cut, refs.data(), right);
    counters.touches += refs.size();
    if (n.left == refs.size() && n.right == refs.size()) return leaf(refs, cell, depth);  // separates nothing
    if (builder_.clips() && context_.mesh != nullptr) {
      n.left = clip_straddlers(*context_.mesh, refs.first(n.left), plane, halves.left);
      n.right = clip_straddlers(*context_.mesh, {right, n.right}, plane, halves.right);
    }
    lists.take(n.right);
    const Slot slot = Slot::binary(plane, *pair);
    AtomicSlot* children = context_.tree.children(slot);
    if (std::min(n.left, n.right) >= kTask) {
      grow_both(refs.first(n.left), {right, n.right}, halves, depth + 1, children, lists, counters);
    } else {
      set(children[0], grow(refs.first(n.left), halves.left, depth + 1, lists, counters));
      set(children[1], grow({right, n.right}, halves.right, depth + 1, lists, counters));
    }
    lists.release(mark);
    return slot;
  }

 private:
  /// Not published until the slot of the whole subtree is.
  static void set(AtomicSlot& slot, Slot value) { slot.store(value.bits(), std::memory_order_relaxed); }

  void grow_both(std::span<BoxRef> left, std::span<BoxRef> right, const HalvedCell& halves, int depth,
                 AtomicSlot* children, ListStack& lists, BuildCounters& counters) {
    BuildCounters right_counters;
    tbb::task_group group;
    group.run([&] {
      ListStack own;
      set(children[1], grow(right, halves.right, depth, own, right_counters));
    });
    try {
      set(children[0], grow(left, halves.left, depth, lists, counters));
    } catch (...) {
      group.cancel();
      group.wait();
      throw;
    }
    group.wait();
    counters += right_counters;
  }

  Slot leaf(std::span<const BoxRef> refs, const Aabb& cell, int depth) {
    const std::optional<Slot> slot = context_.tree.make_leaf(refs);
    return slot ? *slot : defer(refs, cell, depth, true);
  }

  Slot defer(std::span<const BoxRef> refs, const Aabb& box, int depth, bool given_up) {
    BoxList list(refs.size());
    std::copy(refs.begin(), refs.end(), list.all().begin());
    return context_.tree.defer(std::move(list), box, depth, given_up);
  }

  const GrowContext& context_;
  const Builder& builder_;
};

}  // namespace

int depth_limit(std::size_t references) {
  const auto log2 = static_cast<double>(std::bit_width(references));
  return std::min(static_cast<int>(8 + 1.3 * log2) + 20, kMaxTreeDepth);
}

Slot grow(const GrowContext& context, std::span<BoxRef> refs, const Aabb& cell, int depth, BuildCounters& counters) {
  ListStack lists;
  return std::visit(
      [&](const auto& builder) { return Growth(context, builder).grow(refs, cell, depth, lists, counters); },
      context.builder);
}

}  // namespace sightline::accel
