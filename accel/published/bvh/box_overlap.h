// The intersection of two boxes.
#pragma once

#include <algorithm>
#include <cstddef>

#include "accel/geometry/aabb.h"

namespace sightline::accel::published::bvh {

/// Half the surface of the intersection; 0 if the boxes are disjoint.
inline double common_half_area(const geometry::Aabb& a, const geometry::Aabb& b) {
  geometry::Aabb common;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    common.lo[axis] = std::max(a.lo[axis], b.lo[axis]);
    common.hi[axis] = std::min(a.hi[axis], b.hi[axis]);
  }
  return common.empty() ? 0 : half_area(common);
}

}  // namespace sightline::accel::published::bvh
