// Pencils: rays of up to four packets that run through one point, as those of a camera or toward a
// light. They walk as one: their directions are a rectangle, their edges planes through the point.
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

inline constexpr std::size_t kPencilPackets = 4;

/// Rays of each packet.
using PencilLanes = std::array<std::uint32_t, kPencilPackets>;

/// Takes rays through the finished tree below `root`. Returns the rays that are done: the best hits
/// of their packets are settled. The others are not of one pencil, or the tree is not finished
/// where they go, or they meet more blocks than suits a pencil; what their packets have found are
/// hits, but not all that count.
///
/// A pencil is of rays with one origin and tmin >= 0; or of rays that ask for any hit, with equal
/// ends at t = 1, nearly, and 0 <= tmin, tmax <= 1. Needs packet.rays, best, goal, culling, node
/// and instance, which all packets share; sets packet.floats in part, for rays that are done.
PencilLanes walk_pencil(std::span<Packet> packets, const Frame& frame, Child root,
                        const PencilLanes& lanes, kdtree::WalkCounters& counters);

}  // namespace sightline::accel::wide
