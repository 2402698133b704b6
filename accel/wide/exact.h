// The exact rule for the pairs that floats leave undecided.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// The rays of `lanes` that see a triangle.
inline std::uint32_t seeing(const Packet& packet, std::uint32_t id, std::uint32_t lanes) {
  const Visibility* const visible = packet.placed.visible;
  return visible == nullptr ? lanes : visible->seeing(visible->asked, packet.placed.of(id), lanes);
}

/// Decides one pair now. Returns whether the ray's limits were tightened.
bool decide(Packet& packet, std::size_t lane, const std::uint32_t* block, std::uint32_t triangle);

/// Decides one triangle for several rays. Returns whether the limits of any were tightened.
bool decide_lanes(Packet& packet, std::uint32_t lanes, const std::uint32_t* block,
                  std::uint32_t triangle);

/// Counts a hit that is certain and within the ray's limits, for Goal::kEvery without a list.
inline void add_certain(Packet& packet, std::size_t lane, const std::uint32_t* block,
                        std::uint32_t triangle) {
  packet.best->found |= 1u << lane;
  packet.sinks[lane].primitives->add(blocks::Block(block).id(triangle));
}

/// Remembers a pair that may be the ray's nearest hit, at this depth or beyond. If there are too
/// many, the ones that cannot be the nearest any more are forgotten, or the pair is decided now.
void remember(Packet& packet, std::size_t lane, const std::uint32_t* block, std::uint32_t triangle,
              float low);

/// Decides all that these rays remember, several at a time.
void resolve(Packet& packet, std::uint32_t lanes);

}  // namespace sightline::accel::wide
