// Sifting: divides a cell's list by a plane; a straddler goes to both sides. Source: Hunt et al.
// 2006, section 6.3.1. Differs: lists hold the boxes, not pointers to them
// (docs/decisions/trees.md, Lists hold boxes).
#pragma once

#include <cstddef>
#include <span>

#include "accel/kdtree/reference.h"

namespace sightline::accel::kdtree {

struct PartitionCounts {
  std::size_t left = 0;
  std::size_t right = 0;
};

/// Divides by the rule of membership alone, as the overload below does for splits without
/// planar_left.
inline PartitionCounts sift(std::span<const Reference> refs, const Plane& plane, Reference* left,
                            Reference* right) {
  const auto axis = static_cast<std::size_t>(plane.axis);
  const float x = plane.position;
  Reference *end_of_left = left, *end_of_right = right;
  for (const Reference& ref : refs) {
    const bool in_left = ref.lo[axis]<x, in_right = ref.hi[axis]> x;
    const Reference copy = ref;  // `ref` may be in the memory that `left` writes
    *end_of_right = copy;
    *end_of_left = copy;
    end_of_left += in_left;
    end_of_right += in_right;
  }
  return {static_cast<std::size_t>(end_of_left - left),
          static_cast<std::size_t>(end_of_right - right)};
}

/// Writes the members of the left cell to `left` and those of the right cell to `right`, in order.
/// Each has capacity for refs.size() references; `left` may be refs.data(). There is no branch per
/// reference: both sides are always written, and an end advances only if the reference belongs
/// there.
inline PartitionCounts sift(std::span<const Reference> refs, const Split& cut, Reference* left,
                            Reference* right) {
  if (!cut.planar_left) return sift(refs, cut.plane, left, right);
  const auto axis = static_cast<std::size_t>(cut.plane.axis);
  const float x = cut.plane.position;
  PartitionCounts n;
  for (const Reference& ref : refs) {
    const bool planar = ref.lo[axis] == x && is_planar(ref, axis);
    const bool in_left = ref.lo[axis] < x || planar, in_right = ref.hi[axis] > x && !planar;
    const Reference copy = ref;
    right[n.right] = copy;
    left[n.left] = copy;
    n.left += in_left;
    n.right += in_right;
  }
  return n;
}

}  // namespace sightline::accel::kdtree
