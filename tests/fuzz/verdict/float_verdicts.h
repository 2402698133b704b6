// What the float tests say of rays, boxes and triangles, outside of a walk.
#pragma once

#include <array>
#include <cstdint>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/wide_node.h"
#include "accel/wide/packet.h"

namespace sightline::tests {

/// By lane, as accel/wide/verdict-inl.h has them.
struct FloatVerdicts {
  std::uint32_t possible = 0, certain = 0;
  accel::wide::Column<float> depth, off;
};

/// One triangle, relative to the tree's center, for the rays of a prepared packet, each on its
/// own.
FloatVerdicts judge(const accel::wide::Packet& packet,
                    const std::array<accel::geometry::Vec3f, 3>& corners, std::uint32_t lanes);

/// The children that a group of rays with equal keys may meet, and where the first ray may enter
/// each.
struct GroupMeeting {
  std::uint32_t met = 0;
  alignas(64) std::array<float, accel::kdtree::kWidth> in;
};
GroupMeeting meet(const accel::wide::Packet& packet, std::uint32_t group,
                  const accel::kdtree::WideNode& node);

/// The triangles of a block that a group of rays with equal keys may meet.
std::uint32_t possible(const accel::wide::Packet& packet, std::uint32_t group,
                       const std::uint32_t* block);

}  // namespace sightline::tests
