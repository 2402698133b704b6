// What rays do where their walk of one of the scene's trees meets leaves, and cells that are not
// built.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "accel/kdtree/traverse.h"
#include "accel/lazy/lazy_tree.h"
#include "scenegraph/query/caster.h"
#include "scenegraph/query/entered.h"
#include "scenegraph/query/seen.h"

namespace sightline::scenegraph::query {

/// Made for one packet and one tree.
class Caster::SceneSlots final : public accel::wide::SlotVisitor {
 public:
  SceneSlots(Caster& caster, const instances::OpenTree& tree, accel::kdtree::BuildCounters& built)
      : caster_(caster),
        tree_(tree.instances),
        open_(tree),
        first_(static_cast<std::uint32_t>(tree.first)),
        built_(built) {}

  /// Takes the rays through the tree: together, and those that floats do not suit one by one.
  void walk(const accel::wide::Prepared& prepared) {
    live_ = prepared.live;
    if (live_ != 0) walk_together();
    each(prepared.slow, [&](std::size_t lane) { go_alone(tree_.tree().root(), lane); });
  }

  /// For a tree of one instance: its box need not be tested, as its mesh's will be.
  void visit_only(std::uint32_t id, std::uint32_t lanes) {
    const instances::Instance& instance = tree_[id];
    lanes = caster_.masks_.seeing(instance.mask, lanes);
    if (lanes != 0 && is_seen(open_, id, caster_.options_.selection))
      caster_.enter(instance, first_ + id, lanes, built_);
  }

  bool visit(accel::kdtree::AtomicSlot& slot, std::uint32_t lanes) override {
    const accel::kdtree::Slot now = accel::kdtree::load(slot);
    if (now.is_leaf()) {
      std::uint32_t storage;
      if (now.leaf_count() > 0) visit_instances(tree_.tree().tree().leaf(now, storage), lanes);
      return false;
    }
    if (now.is_deferred()) return visit_deferred(slot, *now.cell(), lanes);
    each(lanes, [&](std::size_t lane) { go_alone(slot, lane); });
    return false;
  }

 private:
  /// What a single ray does on its way through the kd-tree.
  struct LaneVisit {
    SceneSlots& slots;
    std::size_t lane;

    double limit() const { return slots.limit(lane); }
    bool leaf(std::span<const std::uint32_t> ids) {
      slots.visit_instances(ids, 1u << lane);
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
      const Caster& caster = slots.caster_;
      return caster.scene_.stopped || caster.left_to_cast(1u << lane) == 0;
    }
  };

  template <class Visit>
  void each(std::uint32_t lanes, const Visit& visit) const {
    for (; lanes != 0 && !caster_.scene_.stopped; lanes &= lanes - 1)
      visit(static_cast<std::size_t>(std::countr_zero(lanes)));
  }

  void walk_together() {
    if (tree_.is_searched()) return search_all(live_);
    accel::wide::WalkTotals totals;
    const accel::wide::Child entry = tree_.tree().entry();
    // No renewing of the pin while the walk is in these nodes.
    caster_.lazy_.searches_list = entry.is_node();
    accel::wide::walk(caster_.scene_, entry, live_, *this, totals);
    caster_.lazy_.searches_list = false;
    caster_.counters_.walked.steps += totals.nodes;
  }

  void go_alone(accel::kdtree::AtomicSlot& slot, std::size_t lane) {
    const accel::wide::Rays& rays = caster_.scene_.rays;
    const accel::geometry::LocalRay ray = accel::wide::ray_of(rays, lane);
    accel::lazy::LazyTree& tree = tree_.tree();
    const double tmax = std::min(rays.tmax[lane], caster_.best_.t[lane]);
    alone_.emplace();
    if (!accel::kdtree::enter(ray, tree.tree().bounds(), rays.tmin[lane] / ray.unit,
                              tmax / ray.unit, *alone_))
      return alone_.reset();
    const std::uint64_t before = caster_.counters_.walked.steps;
    if (&slot == &tree.root() && tree_.is_searched()) {
      search_all(1u << lane);
    } else {
      LaneVisit visit{*this, lane};
      accel::kdtree::walk(tree.tree(), *alone_, slot, caster_.counters_.walked, visit);
      tree.count_steps(caster_.counters_.walked.steps - before);
    }
    alone_.reset();
    caster_.scene_.work[lane] +=
        static_cast<std::uint32_t>(caster_.counters_.walked.steps - before);
  }

  /// Of a ray that is alone: the t beyond which nothing matters any more.
  double limit(std::size_t lane) const {
    return caster_.best_.t[lane] / alone_->local->unit + alone_->slack;
  }

  /// True: the slot has changed.
  bool visit_deferred(accel::kdtree::AtomicSlot& slot, const accel::kdtree::DeferredCell& cell,
                      std::uint32_t lanes) {
    const accel::lazy::OnDeferred on_deferred = caster_.on_deferred_;
    if (on_deferred == accel::lazy::OnDeferred::kSkip) {
      caster_.saw_deferred_ |= lanes;
      return false;
    }
    if (on_deferred != accel::lazy::OnDeferred::kScan) {
      const accel::lazy::ExpandResult expanded =
          tree_.tree().expand(slot, caster_.lazy_.when_pending, built_, caster_.options_.cancelled);
      if (expanded == accel::lazy::ExpandResult::kRetry) return true;
      if (expanded == accel::lazy::ExpandResult::kPending) {
        caster_.suspended_ |= lanes;
        caster_.progress_ = accel::lazy::LazyTree::progress(slot);
        return false;
      }
    }
    caster_.saw_deferred_ |= lanes;
    search(cell, lanes);
    return false;
  }

  void search(const accel::kdtree::DeferredCell& cell, std::uint32_t lanes) {
    if (!cell.has_list) return search_references(tree_.coarsest(), lanes);
    const bool searched_before = std::exchange(caster_.lazy_.searches_list, true);
    cell.list.any_part([&](std::span<const accel::kdtree::Reference> refs) {
      search_references(refs, lanes);
      return caster_.scene_.stopped || caster_.left_to_cast(lanes) == 0;
    });
    caster_.lazy_.searches_list = searched_before;
  }

  /// Instead of a walk: see instances::Instances::is_searched.
  void search_all(std::uint32_t lanes) {
    const std::uint64_t before = tests_;
    search_references(tree_.coarsest(), lanes);
    caster_.counters_.walked.steps += tests_ - before;
    tree_.count_searched(tests_ - before);
  }

  void search_references(std::span<const accel::kdtree::Reference> refs, std::uint32_t lanes) {
    for (const accel::kdtree::Reference& ref : refs) {
      ++tests_;
      lanes = caster_.left_to_cast(lanes);
      if (caster_.lazy_.is_cancelled()) caster_.scene_.stopped = true;
      if (lanes == 0 || caster_.scene_.stopped) return;
      const std::uint32_t met = meeting(ref.bounds(), lanes);
      if (met != 0) visit_reference(ref, met);
    }
  }

  /// For rays that may meet its box. Opens groups.
  void visit_reference(const accel::kdtree::Reference& ref, std::uint32_t lanes) {
    if (!ref.openable()) return visit_instances(std::span(&ref.id, 1), lanes);
    const auto cluster = tree_.members_of_cluster(ref);
    if (!cluster.empty()) return search_references(cluster, lanes);
    if (caster_.on_deferred_ == accel::lazy::OnDeferred::kSkip && !tree_.is_open(ref)) {
      caster_.saw_deferred_ |= lanes;
      return;
    }
    std::vector<accel::kdtree::Reference> members;
    tree_.open(ref, members);
    search_references(members, lanes);
  }

  /// Whether an instance is entered depends only on the ray and the instance's box, not on the cell
  /// that holds it.
  void visit_instances(std::span<const std::uint32_t> ids, std::uint32_t lanes) {
    for (const std::uint32_t id : ids) {
      lanes = caster_.left_to_cast(lanes);
      if (lanes == 0 || caster_.scene_.stopped) return;
      const instances::Instance& instance = tree_[id];
      std::uint32_t entering = caster_.masks_.seeing(instance.mask, recent_.add(id, lanes));
      if (entering != 0) entering = meeting(instance.box, entering);
      if (entering == 0 || !is_seen(open_, id, caster_.options_.selection)) continue;
      if (!caster_.collected_.empty()) entering = caster_.entering(first_ + id, entering);
      caster_.enter(instance, first_ + id, entering, built_);
      tighten(first_ + id, entering);
    }
  }

  /// After these rays have entered an instance.
  void tighten(std::uint32_t index, std::uint32_t lanes) {
    const accel::wide::BestHits& best = caster_.best_;
    if (caster_.scene_.any || caster_.scene_.stopped || caster_.kind_ == QueryKind::kCount) return;
    each(lanes & live_ & best.found, [&](std::size_t lane) {
      const bool here = caster_.kind_ == QueryKind::kAll || best.instance[lane] == index;
      // Not for a list that is not full.
      if (here && best.t[lane] < std::numeric_limits<double>::max())
        accel::wide::tighten(caster_.scene_, lane);
    });
  }

  std::uint32_t meeting(const accel::geometry::Aabb& box, std::uint32_t lanes) const {
    if (alone_) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      return accel::kdtree::may_meet(*alone_, box, limit(lane)) ? lanes : 0;
    }
    const accel::geometry::Vec3f& center = caster_.scene_.center;
    return accel::wide::meeting(caster_.scene_, {box.lo - center, box.hi - center}, lanes);
  }

  Caster& caster_;
  const instances::Instances& tree_;
  const instances::OpenTree& open_;
  const std::uint32_t first_;
  accel::kdtree::BuildCounters& built_;
  std::uint32_t live_ = 0;  // the rays in floats
  RecentLanes recent_;
  std::uint64_t tests_ = 0;                      // of references
  std::optional<accel::kdtree::TreeRay> alone_;  // the ray that goes alone, in doubles
};

}  // namespace sightline::scenegraph::query
