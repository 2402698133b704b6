#include "accel/mesh/packet_query.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
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
  bool references(std::span<const kdtree::Reference> refs) { return kept(test_.references(refs)); }
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

/// One of several rays that search a list.
struct LaneSearch {
  LaneSearch(const PacketWalk& walk, wide::Packet& packet, std::size_t lane)
      : alone(walk, packet, lane), test{walk.mesh, alone.query, ray, walked} {}

  LaneQuery alone;
  kdtree::TreeRay ray;
  kdtree::WalkCounters walked;
  LeafTest test;
};

/// Whether the ray can meet the tree within the limits of its query. Then `ray` is set.
bool enter_tree(const PacketWalk& walk, const MeshQuery& query, kdtree::TreeRay& ray) {
  const double tmax = std::min(query.tmax, query.best_t);
  return enter(query.ray, walk.tree.tree().bounds(), query.tmin / query.ray.unit,
               tmax / query.ray.unit, ray);
}

/// All rays of the packet stop.
void wait_at(const PacketWalk& walk, wide::Packet& packet, kdtree::AtomicSlot* slot) {
  walk.lazy.wait_at(walk.tree, slot);
  packet.stopped = true;
}

/// Rays of a packet that search a cell together, so that its list is read once.
class PacketSearch {
 public:
  PacketSearch(const PacketWalk& walk, wide::Packet& packet, std::uint32_t lanes)
      : walk_(walk), packet_(packet) {
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      LaneSearch& search = searches_[lane].emplace(walk, packet, lane);
      if (enter_tree(walk, search.alone.query, search.ray)) searching_ |= 1u << lane;
    }
  }

  void search(const kdtree::DeferredCell& cell) {
    cell.last_use.use();
    if (cell.list.is_compact()) {
      for (std::span<const std::uint32_t> ids = cell.list.ids(); !ids.empty() && searching_ != 0;
           ids = ids.subspan(std::min(ids.size(), lazy::kSearchStep)))
        each([&](LeafTest& test) {
          return test.leaf(ids.first(std::min(ids.size(), lazy::kSearchStep)));
        });
      return;
    }
    if (cell.has_list) {
      cell.list.any_part([&](std::span<const kdtree::Reference> refs) {
        for (; !refs.empty() && searching_ != 0;
             refs = refs.subspan(std::min(refs.size(), lazy::kSearchStep)))
          each([&](LeafTest& test) {
            return test.references(refs.first(std::min(refs.size(), lazy::kSearchStep)));
          });
        return searching_ == 0;
      });
      return;
    }
    each([](LeafTest& test) { return test.everything(); });
  }

  /// Writes what they have found back to the packet.
  void end() {
    for (std::optional<LaneSearch>& search : searches_) {
      if (!search) continue;
      search->alone.write_back();
      const std::uint64_t work = search->walked.steps + search->walked.tests;
      packet_.work[search->alone.lane()] += static_cast<std::uint32_t>(work);
      walk_.walked.steps += search->walked.steps;
      walk_.walked.tests += search->walked.tests;
    }
    packet_.stopped = walk_.lazy.is_cancelled();
  }

 private:
  /// Those for which it returns true have ended.
  template <class Search>
  void each(const Search& search) {
    for (std::uint32_t left = searching_; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      if (search(searches_[lane]->test)) searching_ &= ~(1u << lane);
    }
  }

  const PacketWalk& walk_;
  wide::Packet& packet_;
  std::array<std::optional<LaneSearch>, wide::kLanes> searches_;
  std::uint32_t searching_ = 0;
};

class UnfinishedSlots final : public wide::SlotVisitor {
 public:
  UnfinishedSlots(const PacketWalk& walk, wide::Packet& packet) : walk_(walk), packet_(packet) {}

  bool visit(kdtree::AtomicSlot& slot, std::uint32_t lanes) override {
    const kdtree::Slot now = kdtree::load(slot);
    if (now == kdtree::Slot::empty_leaf()) return false;
    if (now.is_deferred() && walk_.lazy.on_deferred == lazy::OnDeferred::kWait) {
      wait_at(walk_, packet_, &slot);
      return false;
    }
    if (now.is_deferred()) {
      if (searches(*now.cell(), lanes)) {
        search(*now.cell(), lanes);
        return false;
      }
      if (walk_.lazy.on_deferred != lazy::OnDeferred::kSkip) {
        const std::optional<bool> done = expand(slot);
        if (done) return *done;
      }
    }
    ask_each(walk_, packet_, lanes, [&](LaneQuery& alone) { advance(slot, alone); });
    return false;
  }

 private:
  bool searches(const kdtree::DeferredCell& cell, std::uint32_t lanes) {
    if (walk_.lazy.on_deferred == lazy::OnDeferred::kScan) return true;
    if (walk_.lazy.on_deferred == lazy::OnDeferred::kSkip) return false;
    const auto rays = static_cast<std::uint64_t>(std::popcount(lanes));
    return walk_.tree.searches(cell, rays, walk_.lazy.on_deferred == lazy::OnDeferred::kDemand,
                               walk_.built);
  }

  void search(const kdtree::DeferredCell& cell, std::uint32_t lanes) {
    walk_.saw_deferred |= lanes;
    PacketSearch together(walk_, packet_, lanes);
    together.search(cell);
    together.end();
  }

  /// What visit() returns; nothing: the rays search the list.
  std::optional<bool> expand(kdtree::AtomicSlot& slot) {
    const lazy::ExpandResult expanded =
        walk_.tree.expand(slot, walk_.lazy.when_pending, walk_.built, walk_.lazy.cancelled);
    if (expanded == lazy::ExpandResult::kRetry) {
      walk_.lazy.renew_pin();
      return true;
    }
    if (expanded == lazy::ExpandResult::kScanList) return std::nullopt;
    walk_.lazy.suspended = true;
    walk_.lazy.progress = lazy::LazyTree::progress(slot);
    packet_.stopped = true;
    return false;
  }

  void advance(kdtree::AtomicSlot& slot, LaneQuery& alone) {
    MeshQuery& query = alone.query;
    kdtree::TreeRay ray;
    if (!enter_tree(walk_, query, ray)) return;
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
  query.ray = wide::ray_of(rays, lane);
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
  if (walk.lazy.on_deferred == lazy::OnDeferred::kWait && prepared.live != 0 &&
      walk.tree.has_paid_for_all()) {
    wait_at(walk, packet, nullptr);
    return 0;
  }
  walk.tree.count_rays(static_cast<std::uint64_t>(std::popcount(lanes)));
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
