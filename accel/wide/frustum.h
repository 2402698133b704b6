// Frustums: rays of up to four packets that run through one point, as from a camera or toward a
// light. They are tested as one: their directions fill a rectangle, and an edge of a triangle
// becomes a plane through the point.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/wide/child.h"
#include "accel/wide/frame.h"
#include "accel/wide/packet.h"
#include "accel/wide/walk.h"

namespace sightline::accel::wide {

inline constexpr std::size_t kFrustumPackets = 4;

/// A set of the rays of each packet.
using FrustumLanes = std::array<std::uint32_t, kFrustumPackets>;

/// Takes rays through the finished tree below `root`. Returns the rays that are done: the best hits
/// of their packets are resolved. The others are not of one frustum, or come to a part of the tree
/// that is not finished, or to more blocks than suits a frustum; their packets have found true
/// hits, but not all that count.
///
/// The rays of a frustum have one origin and tmin >= 0; or they ask for any hit, and have nearly
/// equal ends at t = 1, and 0 <= tmin, tmax <= 1. Needs packet.rays, best, goal, culling, node and
/// instance, which all packets share; sets packet.floats in part, for rays that are done.
FrustumLanes walk_frustum(std::span<Packet> packets, const Frame& frame, Child root,
                          const FrustumLanes& lanes, kdtree::WalkCounters& counters);

}  // namespace sightline::accel::wide
