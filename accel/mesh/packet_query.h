// A packet of rays in the tree of a mesh: wide trees take the packet, and what is not finished
// takes one ray after the other.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "accel/mesh/leaf_test.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/walk.h"

namespace sightline::accel::mesh {

/// One ray of a packet as a query of its own. Writes what that finds back to the packet.
class LaneQuery {
 public:
  LaneQuery(const PacketQuery& of, wide::Packet& packet, std::size_t lane);

  MeshQuery query;
  std::size_t lane() const { return lane_; }
  /// Copies a better hit to the packet.
  void write_back();
  /// Copies a better hit from the packet.
  void take_over();

 private:
  wide::Packet& packet_;
  const std::size_t lane_;
};

/// Calls ask(LaneQuery&) for each ray, until one stops the packet.
template <class Ask>
void ask_each(const PacketQuery& of, wide::Packet& packet, std::uint32_t lanes, const Ask& ask) {
  for (; lanes != 0 && !packet.stopped; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    const std::uint64_t before = of.walked.steps + of.walked.tests;
    const std::uint32_t counted = packet.work[lane];
    LaneQuery alone(of, packet, lane);
    ask(alone);
    alone.write_back();
    packet.work[lane] =
        counted + static_cast<std::uint32_t>(of.walked.steps + of.walked.tests - before);
    if (alone.query.saw_deferred) of.saw_deferred |= 1u << lane;
    of.lazy = alone.query;
    packet.stopped = of.lazy.suspended || of.lazy.is_cancelled();
  }
}

/// A query of a packet in one tree.
struct PacketWalk : PacketQuery {
  lazy::LazyTree& tree;
  const geometry::MeshView& mesh;
};

/// Finds the hits of the rays in `lanes`; for a tree that makes blocks. Returns the rays that
/// are too far away for floats, which it leaves out.
std::uint32_t query_packet(const PacketWalk& walk, wide::Packet& packet, std::uint32_t lanes);

}  // namespace sightline::accel::mesh
