// Prepares a packet of points for float tests in one tree. docs/distance_rule.md derives all
// bounds.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "accel/geometry/aabb.h"
#include "accel/wide/frame.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// As prepare(), for points: sets packet.near, packet.floats.high, and what prepare() sets of the
/// packet itself. A point that floats cannot represent there has no limit.
std::uint32_t prepare_points(Packet& packet, const Frame& frame, std::uint32_t lanes);

/// As tighten(), for a point.
void tighten_point(Packet& packet, std::size_t lane);

/// The points of `lanes` from which a box, in the tree's frame, may be near enough.
std::uint32_t near_box(const Packet& packet, const geometry::Aabb& box, std::uint32_t lanes);

/// How far a point may be off on an axis, for boxes. It is finite: the box of a child that does not
/// exist is infinitely far.
inline float off_of_boxes(const FloatPoints& near, std::size_t axis, std::size_t lane) {
  return std::min(near.off[lane], 0x1p+100f) + std::fabs(near.low[axis][lane]);
}

/// The point of a lane in the scene.
geometry::Vec3d scene_point(const Packet& packet, std::size_t lane);

/// The distance in the frame of the point's mesh beyond which nothing matters: at most infinity.
double local_limit(const Packet& packet, std::size_t lane);

}  // namespace sightline::accel::wide
