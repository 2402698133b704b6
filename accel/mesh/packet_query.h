// A packet of rays in the tree of a mesh: wide trees take the packet, and what is not finished
// takes one ray after the other.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "accel/mesh/leaf_test.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/walk.h"

namespace sightline::accel::mesh {

/// One ray of a packet as a query of its own. Writes what that finds back to the packet.
class LaneQuery {
 public:
  LaneQuery(wide::Packet& packet, std::size_t lane, const lazy::LazyQuery& lazy);

  MeshQuery query;
  /// Copies a better hit to the packet.
  void write_back();
  /// Copies a better hit from the packet.
  void take_over();

 private:
  wide::Packet& packet_;
  const std::size_t lane_;
};

/// What a query of a packet needs besides the packet.
struct PacketWalk {
  lazy::LazyTree& tree;
  const geometry::MeshView& mesh;
  lazy::LazyQuery& lazy;
  std::uint32_t& saw_deferred;  ///< The rays that met a cell which was skipped or searched.
  kdtree::WalkCounters& walked;
  kdtree::BuildCounters& built;
};

/// Finds the best hits of the rays in `lanes`; for a tree that makes blocks. Returns the rays that
/// are too far away for floats, which it leaves out.
std::uint32_t query_packet(const PacketWalk& walk, wide::Packet& packet, std::uint32_t lanes);

}  // namespace sightline::accel::mesh
