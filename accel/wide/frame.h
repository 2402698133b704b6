// The coordinates of a wide tree.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "accel/geometry/aabb.h"

namespace sightline::accel::wide {

/// The coordinates in which floats see a tree: minus the center, times a power of two, which is 1
/// for trees with leaf blocks. `bounds` are those of the tree in them.
struct Frame {
  geometry::Vec3f center;
  geometry::Aabb bounds;
  float scale = 1;
  bool is_boundless = false;  ///< Whether the tree's bounds are infinite.
  /// How far vertices in blocks, and rays as their meshes see them, may be from where they are;
  /// more than 0 in flat trees alone.
  float error = 0;
};

inline geometry::Aabb in_frame(const Frame& frame, const geometry::Aabb& box) {
  return {(box.lo - frame.center) * frame.scale, (box.hi - frame.center) * frame.scale};
}

/// The largest coordinate of a box, without sign.
inline float largest_coordinate(const geometry::Aabb& box) {
  float size = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    size = std::max({size, std::fabs(box.lo[axis]), std::fabs(box.hi[axis])});
  return size;
}

/// In a frame of these sizes (the largest coordinate of its bounds) float tests neither overflow
/// nor lose what counts to underflow.
inline constexpr float kLeastSize = 0x1p-40f, kLargestSize = 0x1p+60f;

/// Returns the frame of a tree with these bounds, which are not empty. The scale is not 1 only
/// where the size would be out of range.
Frame frame_of(const geometry::Aabb& bounds);

}  // namespace sightline::accel::wide
