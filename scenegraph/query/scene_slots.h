// What a packet does where its walk of one of the scene's trees meets leaves, and cells that
// are not built.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/kdtree/traverse.h"
#include "accel/lazy/lazy_tree.h"
#include "scenegraph/query/packet_caster.h"
#include "scenegraph/query/selection.h"

namespace sightline::scenegraph::query {

/// Made for one packet and one tree.
class PacketCaster::SceneSlots final : public accel::wide::SlotVisitor {
 public:
  SceneSlots(PacketCaster& caster, const instances::OpenTree& tree,
             accel::kdtree::BuildCounters& built)
      : caster_(caster),
        tree_(tree.instances),
        first_(static_cast<std::uint32_t>(tree.first)),
        removed_(tree.removed),
        built_(built) {}

  bool visit(accel::kdtree::AtomicSlot& slot, std::uint32_t lanes) override {
    const accel::kdtree::Slot now = accel::kdtree::load(slot);
    if (now.is_leaf()) {
      std::uint32_t storage;
      visit_leaf(now.leaf_count() > 0 ? tree_.tree().tree().leaf(now, storage)
                                      : std::span<const std::uint32_t>{},
                 lanes);
      return false;
    }
    if (now.is_deferred()) return visit_deferred(slot, *now.cell(), lanes);
    for (; lanes != 0 && !caster_.scene_.stopped; lanes &= lanes - 1)
      go_alone(slot, static_cast<std::size_t>(std::countr_zero(lanes)));
    return false;
  }

  /// Instead of a walk: see instances::Instances::is_searched.
  void search_all(std::uint32_t lanes) {
    visit_references(tree_.coarsest(), lanes);
    caster_.counters_.walked.steps += tests_;
    tree_.count_searched(tests_);
  }

  /// For a tree of one instance: its box need not be tested, as its mesh's will be.
  void visit_only(std::uint32_t id, std::uint32_t lanes) {
    const instances::Instance& instance = tree_[id];
    lanes = caster_.seeing(instance.mask, lanes);
    if (lanes == 0 || !is_seen(id)) return;
    caster_.leads_ = false;
    caster_.enter(instance, first_ + id, lanes, built_);
    caster_.leads_ = true;
  }

 private:
  /// What a single ray does on its way through the kd-tree.
  struct LaneVisit {
    SceneSlots& slots;
    std::size_t lane;

    double limit() const { return static_cast<double>(slots.caster_.scene_.floats.t_out[lane]); }
    bool leaf(std::span<const std::uint32_t> ids) {
      slots.visit_leaf(ids, 1u << lane);
      return is_done();
    }
    static bool finished(const accel::kdtree::FinishedSubtree&) { return false; }
    accel::kdtree::DeferredAction deferred(accel::kdtree::AtomicSlot& slot,
                                           const accel::kdtree::DeferredCell& cell) {
      if (slots.visit_deferred(slot, cell, 1u << lane))
        return accel::kdtree::DeferredAction::kRetry;
      return is_done() ? accel::kdtree::DeferredAction::kStop
                       : accel::kdtree::DeferredAction::kDone;
    }
    bool is_done() const {
      const PacketCaster& caster = slots.caster_;
      return caster.scene_.stopped || caster.left_to_cast(1u << lane) == 0;
    }
  };

  /// True: the slot has changed.
  bool visit_deferred(accel::kdtree::AtomicSlot& slot, const accel::kdtree::DeferredCell& cell,
                      std::uint32_t lanes) {
    const accel::lazy::OnDeferred on_deferred = caster_.lazy_.on_deferred;
    if (on_deferred == accel::lazy::OnDeferred::kExpand ||
        on_deferred == accel::lazy::OnDeferred::kDemand)
      return expand(slot, lanes);
    caster_.saw_deferred_ |= lanes;
    if (on_deferred == accel::lazy::OnDeferred::kScan) search(cell, lanes);
    return false;
  }

  void search(const accel::kdtree::DeferredCell& cell, std::uint32_t lanes) {
    if (cell.has_list) {
      cell.list.any_part([&](std::span<const accel::kdtree::Reference> refs) {
        return visit_references(refs, lanes);
      });
    } else {
      visit_references(tree_.coarsest(), lanes);
    }
  }

  /// True: nothing is left to do for these rays.
  bool visit_references(std::span<const accel::kdtree::Reference> refs, std::uint32_t lanes) {
    return std::any_of(refs.begin(), refs.end(), [&](const accel::kdtree::Reference& ref) {
      ++tests_;
      lanes = caster_.left_to_cast(lanes);
      if (caster_.lazy_.is_cancelled()) caster_.scene_.stopped = true;
      if (lanes == 0 || caster_.scene_.stopped) return true;
      const std::uint32_t met = meeting(ref.bounds(), lanes);
      if (met != 0) visit_reference(ref, met);
      return false;
    });
  }

  /// For rays that may meet its box. Opens groups.
  void visit_reference(const accel::kdtree::Reference& ref, std::uint32_t lanes) {
    if (!ref.openable()) return visit_instance(ref.id, lanes);
    const auto cluster = tree_.members_of_cluster(ref);
    if (!cluster.empty()) {
      visit_references(cluster, lanes);
    } else if (caster_.lazy_.on_deferred == accel::lazy::OnDeferred::kSkip && !tree_.is_open(ref)) {
      caster_.saw_deferred_ |= lanes;
    } else {
      std::vector<accel::kdtree::Reference> members;
      tree_.open(ref, members);
      visit_references(members, lanes);
    }
  }

  /// True: the slot has changed. False: these rays must be cast alone.
  bool expand(accel::kdtree::AtomicSlot& slot, std::uint32_t lanes) {
    const accel::lazy::ExpandResult expanded = tree_.tree().expand(
        slot, accel::lazy::WhenPending::kReturn, built_, caster_.options_.cancelled);
    if (expanded == accel::lazy::ExpandResult::kRetry) return true;
    caster_.alone_ |= lanes;
    return false;
  }

  void go_alone(accel::kdtree::AtomicSlot& slot, std::size_t lane) {
    const accel::wide::Rays& rays = caster_.scene_.rays;
    const accel::geometry::LocalRay ray{
        {rays.origin[0][lane], rays.origin[1][lane], rays.origin[2][lane]},
        {rays.direction[0][lane], rays.direction[1][lane], rays.direction[2][lane]},
        rays.unit[lane]};
    accel::kdtree::TreeRay in_tree;
    const accel::kdtree::KdTree& tree = tree_.tree().tree();
    if (!accel::kdtree::enter(ray, tree.bounds(), rays.tmin[lane] / ray.unit,
                              std::min(rays.tmax[lane], caster_.best_.t[lane]) / ray.unit, in_tree))
      return;
    const std::uint64_t before = caster_.counters_.walked.steps;
    LaneVisit visit{*this, lane};
    accel::kdtree::walk(tree, in_tree, slot, caster_.counters_.walked, visit);
    tree_.tree().count_steps(caster_.counters_.walked.steps - before);
    caster_.scene_.work[lane] +=
        static_cast<std::uint32_t>(caster_.counters_.walked.steps - before);
  }

  void visit_leaf(std::span<const std::uint32_t> ids, std::uint32_t lanes) {
    for (const std::uint32_t id : ids) {
      lanes = caster_.left_to_cast(lanes);
      if (lanes == 0 || caster_.scene_.stopped) return;
      visit_instance(id, lanes);
    }
  }

  bool is_seen(std::uint32_t id) const {
    if (removed_ != nullptr && removed_->has(id)) return false;
    const Selection* selection = caster_.options_.selection;
    return selection == nullptr || selection->selects(first_ + id);
  }

  void visit_instance(std::uint32_t id, std::uint32_t lanes) {
    const instances::Instance& instance = tree_[id];
    lanes = caster_.seeing(instance.mask, recent_.add(id, lanes));
    if (lanes == 0) return;
    lanes = meeting(instance.box, lanes);
    if (lanes != 0 && is_seen(id)) caster_.enter(instance, first_ + id, lanes, built_);
  }

  std::uint32_t meeting(const accel::geometry::Aabb& box, std::uint32_t lanes) const {
    const accel::geometry::Vec3f& center = caster_.scene_.center;
    return accel::wide::meeting(caster_.scene_, {box.lo - center, box.hi - center}, lanes);
  }

  PacketCaster& caster_;
  const instances::Instances& tree_;
  const std::uint32_t first_;
  const instances::RemovedFilter* removed_;
  accel::kdtree::BuildCounters& built_;
  RecentLanes recent_;
  std::uint64_t tests_ = 0;  // of references
};

}  // namespace sightline::scenegraph::query
