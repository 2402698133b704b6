// The exact rule for the pairs that floats leave undecided.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// Decides one pair now. True: the ray's limits were tightened.
bool decide(Packet& packet, std::size_t lane, const std::uint32_t* block, std::uint32_t triangle);

/// As decide() for one triangle and several rays, for any of which it may be true.
bool decide_lanes(Packet& packet, std::uint32_t lanes, const std::uint32_t* block,
                  std::uint32_t triangle);

/// For Goal::kEvery, where hits are counted: adds one that is certain, and within the ray's limits.
inline void add_certain(Packet& packet, std::size_t lane, const std::uint32_t* block,
                        std::uint32_t triangle) {
  packet.best->found |= 1u << lane;
  packet.sinks[lane].primitives->add(blocks::Block(block).id(triangle));
}

/// Remembers a pair that may be the ray's nearest hit, at this depth or beyond. If there are too
/// many, those that cannot be the nearest any more are forgotten, or the pair is decided now.
void remember(Packet& packet, std::size_t lane, const std::uint32_t* block, std::uint32_t triangle,
              float low);

/// Decides all that these rays remember, several at a time.
void settle(Packet& packet, std::uint32_t lanes);

/// As settle() for rays with one origin.
void settle_from_origin(Packet& packet, std::uint32_t lanes);

}  // namespace sightline::accel::wide
