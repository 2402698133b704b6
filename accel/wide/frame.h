// The coordinates of a wide tree.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "accel/geometry/aabb.h"

namespace sightline::accel::wide {

/// What a tree's bounds are to floats. The bounds are minus the center.
struct Frame {
  geometry::Vec3f center;
  geometry::Aabb bounds;
};

/// The maximum norm of a box.
inline float largest_coordinate(const geometry::Aabb& box) {
  float size = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    size = std::max({size, std::fabs(box.lo[axis]), std::fabs(box.hi[axis])});
  return size;
}

/// A tree within these sizes (largest coordinate of its bounds minus the center) may be compiled:
/// float tests neither overflow nor lose what counts to underflow.
inline constexpr float kLeastSize = 0x1p-40f, kLargestSize = 0x1p+60f;

}  // namespace sightline::accel::wide
