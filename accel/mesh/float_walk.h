// One ray through the tree of a mesh: floats find what it may hit, and the leaf test decides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/lazy/walk_lazily.h"
#include "accel/mesh/leaf_test.h"
#include "accel/mesh/packet_query.h"
#include "accel/wide/walk.h"

namespace sightline::accel::mesh {

/// Wide nodes and blocks are visited in floats, slots that are not finished in doubles.
class FloatWalk final : public wide::SlotVisitor, public wide::TriangleVisitor {
 public:
  /// The ray is a lane of the packet, which wide::prepare() has found live, and the query's. If the
  /// query ends at its first hit, the packet has no other ray.
  FloatWalk(const PacketWalk& in, wide::Packet& packet, std::size_t lane, MeshQuery& query);

  /// Takes the ray through the tree below its entry.
  void walk(wide::Child entry);

  bool visit(kdtree::AtomicSlot& slot, std::uint32_t lanes) override;
  void visit(const blocks::Block& block, std::uint32_t triangles) override;

  // For kdtree::walk.
  double limit() const { return test_.limit(); }
  bool leaf(std::span<const std::uint32_t> ids) { return kept(test_.leaf(ids)); }
  bool references(std::span<const kdtree::Reference> refs) { return kept(test_.references(refs)); }
  bool everything() { return kept(test_.everything()); }
  bool finished(const kdtree::FinishedSubtree& subtree);

 private:
  bool kept(bool stop);
  void tighten();

  const PacketWalk& in_;
  wide::Packet& packet_;
  const std::size_t lane_;
  MeshQuery& query_;
  kdtree::TreeRay ray_;
  LeafTest test_;
  wide::WalkTotals totals_;
};

/// Asks for one ray by itself. False: it begins too far away for floats, and nothing was visited.
bool query_in_floats(const PacketWalk& in, MeshQuery& query);

}  // namespace sightline::accel::mesh
