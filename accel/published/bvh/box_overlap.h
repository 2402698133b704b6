// The intersection of two boxes.
#pragma once

#include "accel/geometry/aabb.h"

namespace sightline::accel::published::bvh {

/// Half the surface of the intersection; 0 if the boxes are disjoint.
inline double common_half_area(const geometry::Aabb& a, const geometry::Aabb& b) {
  const geometry::Aabb part = geometry::common(a, b);
  return part.empty() ? 0 : half_area(part);
}

}  // namespace sightline::accel::published::bvh
