// The walk of rays through wide trees and the slots below them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/kdtree/kd_tree.h"
#include "accel/kdtree/walk_counters.h"
#include "accel/wide/packet.h"
#include "accel/wide/wide_node.h"

namespace sightline::accel::wide {

/// What a walk asks where it comes to a slot that is not finished. Refers to a policy with
///   Child enter(kdtree::AtomicSlot& slot, std::uint32_t lanes)
/// which takes these rays through what lies below the slot, and returns where they go on together;
/// nothing: nowhere. It may set Packet::stopped.
class Leaf {
 public:
  template <class Policy>
  explicit Leaf(Policy& policy)
      : policy_(&policy), enter_([](void* of, kdtree::AtomicSlot& slot, std::uint32_t lanes) {
          return static_cast<Policy*>(of)->enter(slot, lanes);
        }) {}

  Child enter(kdtree::AtomicSlot& slot, std::uint32_t lanes) const {
    return enter_(policy_, slot, lanes);
  }

 private:
  void* policy_;
  Child (*enter_)(void* policy, kdtree::AtomicSlot& slot, std::uint32_t lanes);
};

/// What the walks of a packet share.
struct Walked {
  Packet& packet;
  const Leaf& leaf;
  kdtree::WalkCounters& counters;
};

/// Those of `lanes` that may meet a box, relative to the center, before their best hits.
std::uint32_t meeting(const Packet& packet, const geometry::Aabb& box, std::uint32_t lanes);

/// Takes the rays in `lanes`, which prepare() has found live, through the tree below `root`. By
/// Packet::goal: remembers pairs that may be the nearest hits (settle()), finds which rays have a
/// hit, or offers every hit to the sinks.
void walk(Packet& packet, Child root, std::uint32_t lanes, const Leaf& leaf,
          kdtree::WalkCounters& counters);

}  // namespace sightline::accel::wide
