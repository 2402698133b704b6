// Prepares a packet of rays or points for float tests in one tree.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/wide/frame.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// A plane of a box is off by at most this share of the distances of origin and plane; see
/// docs/hit_rule.md, section 7.
inline constexpr float kPlaneError = 0x1.8p-22f;
/// For planes, components of a direction count as at least kLeastDirection. That moves a plane by
/// at most kSteepError times the length of the ray, before the division.
inline constexpr float kLeastDirection = 0x1p-60f, kSteepError = 2 * kLeastDirection;
/// A bound on what is lost to underflow.
inline constexpr float kTiny = 0x1p-110f;

/// Sets packet.floats, or packet.near (float_points.h), from its rays, best hits and culling, for
/// rays in `lanes`. Returns packet.live: the rays that may meet the bounds within their limits.
/// Forgets the candidates.
std::uint32_t prepare(Packet& packet, const Frame& frame, std::uint32_t lanes);

/// Lowers the ray's limits to its best hit, after that has changed.
void tighten(Packet& packet, std::size_t lane);

}  // namespace sightline::accel::wide
