// Splits a list into two equal halves, where the heuristic finds no split.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "accel/kdtree/reference.h"

namespace sightline::accel::published::bvh {

/// The middle of a box along an axis; finite for finite boxes.
inline float center(const kdtree::Reference& ref, std::size_t axis) {
  return 0.5f * ref.lo[axis] + 0.5f * ref.hi[axis];
}

/// Partitions by center, then by id: the lower half first. Returns the length of the first half.
inline std::size_t halve_by_center(std::span<kdtree::Reference> refs, std::size_t axis) {
  const std::size_t half = refs.size() / 2;
  std::nth_element(refs.begin(), refs.begin() + static_cast<std::ptrdiff_t>(half), refs.end(),
                   [axis](const kdtree::Reference& a, const kdtree::Reference& b) {
                     const float x = center(a, axis), y = center(b, axis);
                     return x != y ? x < y : a.id < b.id;
                   });
  return half;
}

}  // namespace sightline::accel::published::bvh
