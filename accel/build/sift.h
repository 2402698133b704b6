// Sifting: dividing a cell's list by a plane; a straddler goes to both sides. Source: Hunt et al.
// 2006, section 6.3.1. Differs: lists hold the boxes, not pointers to them (docs/decisions/0002).
#pragma once

#include <cstddef>
#include <span>

#include "accel/build/box_ref.h"

namespace sightline::accel {

struct Sifted {
  std::size_t left = 0;
  std::size_t right = 0;
};

/// Writes the members of the left cell to `left` and those of the right cell to `right`, in order.
/// Each has room for refs.size() boxes; `left` may be refs.data() itself. Without branches on the
/// boxes: both sides are always written, and the place moves on only if the box belongs there.
inline Sifted sift(std::span<const BoxRef> refs, const Cut& cut, BoxRef* left, BoxRef* right) {
  const auto axis = static_cast<std::size_t>(cut.plane.axis);
  const float x = cut.plane.position;
  Sifted n;
  for (std::size_t i = 0; i < refs.size(); ++i) {
    const BoxRef ref = refs[i];
    right[n.right] = ref;
    left[n.left] = ref;
    const bool planar_left = cut.planar_left & (ref.lo[axis] == x) & is_planar(ref, axis);
    n.left += (ref.lo[axis] < x) | planar_left;
    n.right += (ref.hi[axis] > x) & !planar_left;
  }
  return n;
}

}  // namespace sightline::accel
