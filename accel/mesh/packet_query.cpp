#include "accel/mesh/packet_query.h"

#include <bit>
#include <utility>

#include "accel/mesh/float_walk.h"
#include "accel/wide/exact.h"
#include "accel/wide/float_rays.h"

namespace sightline::accel::mesh {
namespace {

/// What single rays of a packet find in leaves and lists, and, in floats, in finished subtrees.
class LaneTest {
 public:
  LaneTest(const PacketWalk& walk, wide::Packet& packet, LaneQuery& lane_query,
           const kdtree::TreeRay& ray, wide::SlotVisitor& slots)
      : walk_(walk),
        packet_(packet),
        lane_(lane_query.lane()),
        lane_query_(lane_query),
        slots_(slots),
        test_{walk.mesh, lane_query.query, ray, walk.walked} {}

  double limit() const { return static_cast<double>(packet_.floats.t_out[lane_]); }
  bool leaf(std::span<const std::uint32_t> ids) { return kept(test_.leaf(ids)); }
  bool reference(const kdtree::Reference& ref) { return kept(test_.reference(ref)); }
  bool everything() { return kept(test_.everything()); }

  bool finished(const kdtree::FinishedSubtree& subtree) {
    wide::WalkTotals totals;
    walk(packet_, static_cast<const wide::WideTree&>(subtree).root(), 1u << lane_, slots_, totals);
    walk_.walked.steps += totals.nodes;
    walk_.walked.tests += totals.triangles;
    lane_query_.take_over();
    return packet_.any && lane_query_.query.found;
  }

 private:
  bool kept(bool stop) {
    lane_query_.write_back();
    return stop;
  }

  const PacketWalk& walk_;
  wide::Packet& packet_;
  const std::size_t lane_;
  LaneQuery& lane_query_;
  wide::SlotVisitor& slots_;
  LeafTest test_;
};

class UnfinishedSlots final : public wide::SlotVisitor {
 public:
  UnfinishedSlots(const PacketWalk& walk, wide::Packet& packet) : walk_(walk), packet_(packet) {}

  bool visit(kdtree::AtomicSlot& slot, std::uint32_t lanes) override {
    const kdtree::Slot now = kdtree::load(slot);
    if (now == kdtree::Slot::empty_leaf()) return false;
    if (now.is_deferred() && walk_.lazy.on_deferred == lazy::OnDeferred::kExpand) {
      const lazy::ExpandResult expanded =
          walk_.tree.expand(slot, walk_.lazy.when_pending, walk_.built, walk_.lazy.cancelled);
      if (expanded == lazy::ExpandResult::kRetry) {
        walk_.lazy.renew_pin();
        return true;
      }
      if (expanded == lazy::ExpandResult::kPending) {
        walk_.lazy.suspended = true;
        walk_.lazy.progress = lazy::LazyTree::progress(slot);
        packet_.stopped = true;
        return false;
      }
    }
    ask_each(walk_, packet_, lanes, [&](LaneQuery& alone) { advance(slot, alone); });
    return false;
  }

 private:
  void advance(kdtree::AtomicSlot& slot, LaneQuery& alone) {
    MeshQuery& query = alone.query;
    kdtree::TreeRay ray;
    const double tmax = std::min(query.tmax, query.best_t);
    if (!enter(query.ray, walk_.tree.tree().bounds(), query.tmin / query.ray.unit,
               tmax / query.ray.unit, ray))
      return;
    const std::uint64_t steps = walk_.walked.steps;
    LaneTest test(walk_, packet_, alone, ray, *this);
    lazy::LazyVisit<LaneTest> visit{walk_.tree, query, walk_.built, test};
    kdtree::walk(walk_.tree.tree(), ray, slot, walk_.walked, visit);
    walk_.tree.count_steps(walk_.walked.steps - steps);
  }

  const PacketWalk& walk_;
  wide::Packet& packet_;
};

}  // namespace

LaneQuery::LaneQuery(const PacketQuery& of, wide::Packet& packet, std::size_t lane)
    : packet_(packet), lane_(lane) {
  static_cast<lazy::LazyQuery&>(query) = of.lazy;
  if (!of.sinks.empty()) static_cast<HitSinks&>(query) = of.sinks[lane];
  query.saw_deferred = false;
  const wide::Rays& rays = packet.rays;
  query.ray = {{rays.origin[0][lane], rays.origin[1][lane], rays.origin[2][lane]},
               {rays.direction[0][lane], rays.direction[1][lane], rays.direction[2][lane]},
               rays.unit[lane]};
  query.tmin = rays.tmin[lane];
  query.tmax = rays.tmax[lane];
  query.culling = packet.culling;
  query.any = packet.any;
  query.node = packet.node;
  query.instance = packet.instance;
  take_over();
}

void LaneQuery::take_over() {
  const wide::BestHits& best = *packet_.best;
  query.best_t = best.t[lane_];
  query.best_node = best.node[lane_];
  query.best_primitive = best.primitive[lane_];
  query.best_instance = best.instance[lane_];
  query.found = (best.found >> lane_ & 1) != 0;
}

void LaneQuery::write_back() {
  wide::BestHits& best = *packet_.best;
  if (!query.found) return;
  if (best.t[lane_] != query.best_t || best.primitive[lane_] != query.best_primitive ||
      best.instance[lane_] != query.best_instance)
    best.block[lane_] = nullptr;
  best.found |= 1u << lane_;
  const bool nearer = query.best_t < best.t[lane_];
  best.t[lane_] = query.best_t;
  best.node[lane_] = query.best_node;
  best.primitive[lane_] = query.best_primitive;
  best.instance[lane_] = query.best_instance;
  if (nearer) wide::tighten(packet_, lane_);
}

std::uint32_t query_packet(const PacketWalk& walk, wide::Packet& packet, std::uint32_t lanes) {
  const wide::Prepared prepared = wide::prepare(packet, *walk.tree.frame(), lanes);
  // A thread that has renewed its pin may not go on in nodes that are replaced meanwhile.
  const wide::Child entry = walk.tree.entry();
  const bool searched_before =
      std::exchange(walk.lazy.searches_list, walk.lazy.searches_list || entry.is_node());
  if (walk.sinks.empty()) {
    UnfinishedSlots slots(walk, packet);
    wide::WalkTotals totals;
    wide::walk(packet, entry, prepared.live, slots, totals);
    walk.walked.steps += totals.nodes;
    walk.walked.tests += totals.triangles;
  } else {
    ask_each(walk, packet, prepared.live, [&](LaneQuery& alone) {
      FloatWalk(walk, packet, alone.lane(), alone.query).walk(entry);
    });
  }
  walk.lazy.searches_list = searched_before;
  if (walk.sinks.empty() && !packet.any && !packet.stopped) wide::settle(packet, prepared.live);
  return prepared.slow;
}

}  // namespace sightline::accel::mesh
