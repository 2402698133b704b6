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

/// A vector of the tree's frame, stretched if the packet is. Each number is off by at most 8 *
/// 2^-24 of the sum of its terms without signs.
inline geometry::Vec3f stretched(const FloatPoints& near, const geometry::Vec3f& v) {
  if (!near.stretched) return v;
  const auto& r = near.metric;
  return {r[0] * v.x + r[1] * v.y + r[2] * v.z, r[3] * v.y + r[4] * v.z, r[5] * v.z};
}
/// What stretched() makes at most of vectors that are so long on each axis.
inline geometry::Vec3f stretched_off(const FloatPoints& near, const geometry::Vec3f& off) {
  if (!near.stretched) return off;
  const auto& r = near.metric;
  const auto size = [](float x) { return std::fabs(x) * (1 + 0x1p-20f); };
  return {size(r[0]) * off.x + size(r[1]) * off.y + size(r[2]) * off.z,
          size(r[3]) * off.y + size(r[4]) * off.z, size(r[5]) * off.z};
}

/// The point of a lane in the scene.
geometry::Vec3d scene_point(const Packet& packet, std::size_t lane);

/// The distance in the frame of the point's mesh beyond which nothing matters: at most infinity.
double local_limit(const Packet& packet, std::size_t lane);

}  // namespace sightline::accel::wide
