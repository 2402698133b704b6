// Where a slice lies in its scene.
#include "client/cli/picture/slice_frame.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sightline::client::cli::picture {
namespace {

/// Of the larger side, on each side.
constexpr double kFrameMargin = 0.05;

/// An axis of the scene, towards its positive or its negative end.
struct Direction {
  std::size_t axis;
  double sign;
};

struct Directions {
  Direction right, down;
};

Directions directions_on(std::size_t axis, UpAxis up_axis) {
  const std::size_t up = up_axis == UpAxis::kZ ? 2 : 1;
  if (axis != up) return {{3 - axis - up, 1}, {up, -1}};
  // Seen from above: in a scene whose y is up, z comes towards the reader.
  return {{0, 1}, up == 2 ? Direction{1, -1} : Direction{2, 1}};
}

Vec3 along(const Direction& direction, double length) {
  Vec3 vector{};
  vector[direction.axis] = direction.sign * length;
  return vector;
}

}  // namespace

SliceFrame frame_on(const SlicePlane& plane, const SceneInfo& scene, PictureSize size) {
  const std::array<double, 6> bounds =
      scene.bounds.value_or(std::array<double, 6>{-0.5, -0.5, -0.5, 0.5, 0.5, 0.5});
  const auto [right, down] = directions_on(plane.axis, scene.up_axis);
  const auto extent = [&](std::size_t axis) { return bounds[axis + 3] - bounds[axis]; };
  const double margin = kFrameMargin * std::max(extent(right.axis), extent(down.axis));
  double pixel = std::max((extent(right.axis) + 2 * margin) / size.width,
                          (extent(down.axis) + 2 * margin) / size.height);
  if (!(pixel > 0)) pixel = 1.0 / std::max(size.width, size.height);
  SliceFrame frame{.across = along(right, pixel * size.width),
                   .down = along(down, pixel * size.height)};
  for (std::size_t k = 0; k < 3; ++k) {
    const double middle = bounds[k] + (bounds[k + 3] - bounds[k]) / 2;
    frame.origin[k] = middle - (frame.across[k] + frame.down[k]) / 2;
  }
  frame.origin[plane.axis] = plane.at;
  return frame;
}

bool has_area(const SliceFrame& frame) {
  const double across = length(frame.across), down = length(frame.down);
  if (!(across > 0) || !(down > 0) || !std::isfinite(across) || !std::isfinite(down)) return false;
  return length(cross(unit(frame.across), unit(frame.down))) > 1e-9;
}

PointGrid pixels_of(const SliceFrame& frame, PictureSize size) {
  PointGrid grid;
  grid.across = scale(frame.across, 1.0 / size.width);
  grid.down = scale(frame.down, 1.0 / size.height);
  grid.origin = add(frame.origin, scale(add(grid.across, grid.down), 0.5));
  grid.columns = size.width;
  grid.rows = size.height;
  return grid;
}

}  // namespace sightline::client::cli::picture
