#include "accel/wide/frame.h"

#include <limits>

#include "accel/blocks/frame.h"

namespace sightline::accel::wide {
namespace {

/// The power of two that brings a size into the range.
float scale_of(float size) {
  const bool is_small = size < kLeastSize;
  const int exponent = std::ilogb(is_small ? kLeastSize : kLargestSize) + (is_small ? 1 : -1);
  const float known =
      std::clamp(size, std::numeric_limits<float>::min(), std::numeric_limits<float>::max());
  return std::ldexp(1.0f, exponent - std::ilogb(known));
}

geometry::Aabb bounded(geometry::Aabb box) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lo[axis] = std::max(box.lo[axis], -kLargestSize);
    box.hi[axis] = std::min(box.hi[axis], kLargestSize);
  }
  return box;
}

}  // namespace

Frame frame_of(const geometry::Aabb& bounds) {
  Frame frame;
  frame.center = blocks::frame_center(bounds);
  frame.bounds = in_frame(frame, bounds);
  const float size = largest_coordinate(frame.bounds);
  if (size >= kLeastSize && size <= kLargestSize) return frame;
  frame.scale = scale_of(size);
  frame.is_boundless = std::isinf(size);
  frame.bounds = bounded(in_frame(frame, bounds));
  return frame;
}

}  // namespace sightline::accel::wide
