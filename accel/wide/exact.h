// The exact rule for the pairs that floats leave undecided, and the choice between hits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// Keeps a hit if it is within the ray's limits and less than the best by (t, node, primitive). t
/// is in units of the caller's direction. Culling is the caller's.
inline bool offer(Packet& packet, std::size_t lane, double t, const std::uint32_t* block,
                  std::uint32_t triangle) {
  const std::uint32_t primitive = blocks::Block(block).id(triangle);
  BestHits& best = *packet.best;
  if (!(t >= packet.rays.tmin[lane] && t <= packet.rays.tmax[lane])) return false;
  if (t > best.t[lane]) return false;
  if (t == best.t[lane]) {
    if (packet.node > best.node[lane]) return false;
    if (packet.node == best.node[lane] && primitive >= best.primitive[lane]) return false;
  }
  best.t[lane] = t;
  best.node[lane] = packet.node;
  best.primitive[lane] = primitive;
  best.instance[lane] = packet.instance;
  best.block[lane] = block;
  best.triangle[lane] = static_cast<std::uint8_t>(triangle);
  best.center[lane] = packet.center;
  best.found |= 1u << lane;
  return true;
}

/// Decides one pair now.
void decide(Packet& packet, std::size_t lane, const std::uint32_t* block, std::uint32_t triangle);

/// Remembers a pair that may be the ray's nearest hit, at this depth or beyond. If there are too
/// many, those that cannot be the nearest any more are forgotten, or the pair is decided now.
void remember(Packet& packet, std::size_t lane, const std::uint32_t* block, std::uint32_t triangle,
              float low);

/// Decides all that these rays remember, several at a time.
void settle(Packet& packet, std::uint32_t lanes);

/// As settle() for rays with one origin.
void settle_from_origin(Packet& packet, std::uint32_t lanes);

}  // namespace sightline::accel::wide
