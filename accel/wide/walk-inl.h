// The loop of every walk through a tree.
#if defined(SIGHTLINE_WIDE_WALK_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_WALK_INL
#undef SIGHTLINE_WIDE_WALK_INL
#else
#define SIGHTLINE_WIDE_WALK_INL
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "accel/kdtree/wide_node.h"
#include "accel/wide/child.h"
#include "accel/wide/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// A number for each child of a node.
using Boxes = Lanes<float, kdtree::kWidth>;

/// Where a walk goes on later. An entry has `t`, where its rays meet it.
template <class Entry>
class Stack {
 public:
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  HWY_INLINE void push(const Entry& entry) { entries_[size_++] = entry; }
  /// Keeps the entries above `base` in order, the nearest last.
  HWY_INLINE void push_by_distance(const Entry& entry, std::size_t base) {
    std::size_t i = size_++;
    for (; i > base && entries_[i - 1].t < entry.t; --i) entries_[i] = entries_[i - 1];
    entries_[i] = entry;
  }
  HWY_INLINE const Entry& pop() { return entries_[--size_]; }
  const Entry& top() const { return entries_[size_ - 1]; }
  /// Exchanges the nearest entry and the top.
  void raise_nearest() {
    const auto nearer = [](const Entry& a, const Entry& b) { return a.t < b.t; };
    Entry* const end = entries_.data() + size_;
    std::swap(*std::min_element(entries_.data(), end, nearer), *(end - 1));
  }

 private:
  /// A path above finished subtrees and one in such a subtree have at most kMostLevels nodes each.
  static constexpr std::size_t kMost =
      2 * kdtree::kMostLevels * (kdtree::kWidth - 1) + kdtree::kWidth;

  std::size_t size_ = 0;
  std::array<Entry, kMost> entries_;  // not cleared, as one is made for each walk
};

/// Leaves the nearest of these children at `nearest`, and pushes the others, in order if that is
/// asked.
template <bool kInOrder, class Entry>
HWY_INLINE void push_others(Child parent, const std::array<float, kdtree::kWidth>& t,
                            std::uint32_t others, Entry& nearest, Stack<Entry>& stack) {
  const std::size_t base = stack.size();
  for (; others != 0; others &= others - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(others));
    // The two are exchanged without a branch, which would be mispredicted half of the time.
    const std::uint64_t swap = t[i] < nearest.t ? ~std::uint64_t{0} : 0;
    const std::uint64_t child = parent.child(i).bits();
    const std::uint64_t changed = (nearest.at.bits() ^ child) & swap;
    const Entry farther{std::max(t[i], nearest.t), Child::of(child ^ changed)};
    nearest = {std::min(t[i], nearest.t), Child::of(nearest.at.bits() ^ changed)};
    if constexpr (kInOrder) {
      stack.push_by_distance(farther, base);
    } else {
      stack.push(farther);
    }
  }
}

/// Takes rays through the tree below an entry, to the nearest children first. `Rays` has
///   struct Entry { float t; Child at; ... }
///   bool visit_node(Entry&, Stack<Entry>&)
///                             goes on to the nearest child, pushes the others; false: none is met
///   void visit_block(const Entry&)
///   bool enter(Entry&)        goes on where a slot or a list leads; false: nowhere
///   bool part(const Entry&)   whether the rays have gone on from there by themselves
///   bool is_done()
///   bool matters(Entry&)      whether an entry that has waited still does; drops rays
///   bool next(Entry&, Stack<Entry>&)
///                             optional: goes on to an entry that has waited; false: none matters
template <class Rays>
HWY_INLINE void walk_tree(Rays& rays, typename Rays::Entry entry) {
  Stack<typename Rays::Entry> stack;
  for (;;) {
    for (bool on = true; on && !rays.part(entry);) {
      if (entry.at.is_node()) {
        on = rays.visit_node(entry, stack);
      } else if (entry.at.is_block()) {
        rays.visit_block(entry);
        on = false;
      } else {
        on = rays.enter(entry);
      }
    }
    if (rays.is_done()) return;
    if constexpr (requires { rays.next(entry, stack); }) {
      if (!rays.next(entry, stack)) return;
    } else {
      do {
        if (stack.empty()) return;
        entry = stack.pop();
      } while (!rays.matters(entry));
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle
