// The walk of rays through a tree.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/kdtree/walk_counters.h"
#include "accel/wide/child.h"
#include "accel/wide/packet.h"
#include "accel/wide/wide_tree.h"

namespace sightline::accel::wide {

/// A leaf policy, which a walk asks where it comes to something else than nodes and blocks. It
/// refers to an object with
///   Child enter(kdtree::AtomicSlot& slot, std::uint32_t lanes)
///   void visit(std::span<const std::uint32_t> list, std::uint32_t lanes)
/// The first takes these rays through what lies below a slot that is not finished, and returns
/// where they go on together, or nothing. The second takes them to the references of a leaf. Both
/// may set Packet::stopped.
class Leaf {
 public:
  template <class Policy>
  explicit Leaf(Policy& policy)
      : policy_(&policy), enter_([](void* of, Child at, std::uint32_t lanes) {
          Policy& asked = *static_cast<Policy*>(of);
          if (!at.is_list()) return asked.enter(at.slot(), lanes);
          asked.visit(at.list(), lanes);
          return Child();
        }) {}

  Child enter(Child at, std::uint32_t lanes) const { return enter_(policy_, at, lanes); }

 private:
  void* policy_;
  Child (*enter_)(void* policy, Child at, std::uint32_t lanes);
};

/// Returns where rays go on from what is neither a node nor a block, or nothing.
inline Child enter(Child at, std::uint32_t lanes, const Leaf& leaf) {
  if (!at.is_list()) {
    const kdtree::Slot now = kdtree::load(at.slot());
    if (now.is_finished())
      return Child::final(static_cast<const WideTree*>(now.finished())->enter());
  }
  return leaf.enter(at, lanes);
}

/// What the walks of a packet share.
struct Walked {
  Packet& packet;
  const Leaf& leaf;
  kdtree::WalkCounters& counters;
};

/// The rays of `lanes` that may meet a box, which is in the tree's frame, before their best hits.
std::uint32_t meeting(const Packet& packet, const geometry::Aabb& box, std::uint32_t lanes);

/// Takes the rays in `lanes`, which prepare() has found live, through the tree below `root`. By
/// Packet::goal: remembers pairs that may be the nearest hits (resolve()), finds which rays have a
/// hit, or offers every hit to the sinks.
void walk(Packet& packet, Child root, std::uint32_t lanes, const Leaf& leaf,
          kdtree::WalkCounters& counters);

}  // namespace sightline::accel::wide
