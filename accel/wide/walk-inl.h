// The loop of every walk through a tree.
#if defined(SIGHTLINE_WIDE_WALK_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_WALK_INL
#undef SIGHTLINE_WIDE_WALK_INL
#else
#define SIGHTLINE_WIDE_WALK_INL
#endif

#include <array>
#include <cstddef>

#include "accel/kdtree/wide_node.h"
#include "accel/wide/child.h"
#include "accel/wide/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// A number for each child of a node.
using Boxes = Lanes<float, kdtree::kWidth>;

/// Where a walk goes on later. A place has `t`, where its rays meet it.
template <class Place>
class Stack {
 public:
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  HWY_INLINE void push(const Place& place) { places_[size_++] = place; }
  /// Keeps the places above `base` in order, the nearest last.
  HWY_INLINE void push_by_distance(const Place& place, std::size_t base) {
    std::size_t i = size_++;
    for (; i > base && places_[i - 1].t < place.t; --i) places_[i] = places_[i - 1];
    places_[i] = place;
  }
  HWY_INLINE const Place& pop() { return places_[--size_]; }

 private:
  /// A path above finished subtrees and one in such a subtree have at most kMostLevels nodes each.
  static constexpr std::size_t kMost =
      2 * kdtree::kMostLevels * (kdtree::kWidth - 1) + kdtree::kWidth;

  std::size_t size_ = 0;
  std::array<Place, kMost> places_;  // not cleared, as one is made for each walk
};

/// Takes rays through the tree below a place, to the nearest children first. `Rays` has
///   struct Place { float t; Child at; ... }
///   bool visit_node(Place&, Stack<Place>&)  goes on to the nearest child that is met, and pushes
///   the
///                                           others; false: there is none
///   void visit_block(const Place&)
///   bool enter(Place&)         goes on where a slot or a list leads; false: nowhere
///   bool part(const Place&)    whether the rays have gone on from there by themselves
///   bool is_done()
///   bool matters(Place&)       whether a place that has waited still does; drops rays
template <class Rays>
HWY_INLINE void walk_tree(Rays& rays, typename Rays::Place place) {
  Stack<typename Rays::Place> stack;
  for (;;) {
    for (bool on = true; on && !rays.part(place);) {
      if (place.at.is_node()) {
        on = rays.visit_node(place, stack);
      } else if (place.at.is_block()) {
        rays.visit_block(place);
        on = false;
      } else {
        on = rays.enter(place);
      }
    }
    if (rays.is_done()) return;
    do {
      if (stack.empty()) return;
      place = stack.pop();
    } while (!rays.matters(place));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle
