// The walk of rays through wide trees and the slots below them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/kdtree/kd_tree.h"
#include "accel/wide/packet.h"
#include "accel/wide/wide_node.h"

namespace sightline::accel::wide {

/// What to do at slots that are not finished.
class SlotVisitor {
 public:
  virtual ~SlotVisitor() = default;
  /// Takes these rays through what lies below the slot. True: it is finished now, go on there. May
  /// set Packet::stopped.
  virtual bool visit(kdtree::AtomicSlot& slot, std::uint32_t lanes) = 0;
};

/// What to do with the triangles of a block that a ray may hit.
class TriangleVisitor {
 public:
  virtual ~TriangleVisitor() = default;
  /// `triangles` has a bit for each of them. May tighten() the ray, and set Packet::stopped.
  virtual void visit(const blocks::Block& block, std::uint32_t triangles) = 0;
};

/// Work of a walk.
struct WalkTotals {
  std::uint64_t nodes = 0;      ///< Visits of nodes, by each ray.
  std::uint64_t triangles = 0;  ///< Of blocks visited, for each ray.
};

/// What all walks of a packet share.
struct Walked {
  Packet& packet;
  SlotVisitor& slots;
  WalkTotals& totals;
  TriangleVisitor* triangles = nullptr;  ///< For walk_every() alone.
};

/// Those of `lanes` that may meet a box, relative to the center, before their best hits.
std::uint32_t meeting(const Packet& packet, const geometry::Aabb& box, std::uint32_t lanes);

/// Takes the rays in `lanes`, which prepare() has found live, through the tree below `root`.
/// Remembers pairs that may be hits (settle()); with Packet::any, finds whether there is one.
void walk(Packet& packet, Child root, std::uint32_t lanes, SlotVisitor& slots, WalkTotals& totals);

/// Takes one ray through the tree, and visits every triangle, once for each block that holds it,
/// except those that the ray certainly misses within its limits and before its best hit.
void walk_every(Packet& packet, Child root, std::size_t lane, SlotVisitor& slots,
                TriangleVisitor& triangles, WalkTotals& totals);

}  // namespace sightline::accel::wide
