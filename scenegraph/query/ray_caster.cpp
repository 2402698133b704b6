// Walks the scene's trees and asks the meshes of the instances that a ray enters.
#include "scenegraph/query/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "accel/kdtree/walk.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/query/surface.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::kdtree::Reference;
using accel::mesh::MeshQuery;
using accel::mesh::OnDeferred;

OnDeferred on_deferred(Growth growth) {
  switch (growth) {
    case Growth::kNone:
      return OnDeferred::kScan;
    case Growth::kBuiltOnly:
      return OnDeferred::kSkip;
    case Growth::kFirstTouch:
    case Growth::kFull:
      break;
  }
  return OnDeferred::kExpand;
}

}  // namespace

/// What a walk of the static or dynamic tree does at leaves and deferred cells.
struct RayCaster::Visit {
  RayCaster& caster;
  const Ray& ray;
  const Entry& entry;
  MeshQuery& query;
  RecentlyEntered recent;

  double limit() const { return query.best_t / entry.centered.unit + entry.ray.slack; }

  bool leaf(std::span<const std::uint32_t> ids) {
    for (const std::uint32_t id : ids) {
      if (enter(id)) return true;
    }
    return false;
  }

  accel::kdtree::DeferredAction deferred(accel::kdtree::AtomicSlot& slot,
                                         const accel::kdtree::DeferredCell& cell) {
    if (query.on_deferred == OnDeferred::kExpand) {
      const accel::lazy::ExpandResult expanded =
          entry.instances->tree().expand(slot, query.when_pending, *entry.built);
      if (expanded == accel::lazy::ExpandResult::kRetry)
        return accel::kdtree::DeferredAction::kRetry;
      if (expanded == accel::lazy::ExpandResult::kPending) {
        query.suspended = true;
        query.progress = accel::lazy::LazyTree::progress(slot);
        return accel::kdtree::DeferredAction::kStop;
      }
    }
    query.saw_deferred = true;
    if (query.on_deferred == OnDeferred::kSkip) return accel::kdtree::DeferredAction::kDone;
    return search(cell) ? accel::kdtree::DeferredAction::kStop
                        : accel::kdtree::DeferredAction::kDone;
  }

  bool search(const accel::kdtree::DeferredCell& cell) {
    if (cell.has_list)
      return cell.list.any_part([&](std::span<const Reference> refs) { return search(refs); });
    return search(entry.instances->coarsest());
  }

  bool search(std::span<const Reference> refs) {
    return std::any_of(refs.begin(), refs.end(), [&](const Reference& ref) {
      return ref.openable() ? search_below(ref) : enter(ref.id);
    });
  }

  /// Opens groups whose boxes the ray may meet.
  bool search_below(const Reference& ref) {
    std::vector<Reference>& pending = caster.pending_;
    pending.assign(1, ref);
    while (!pending.empty()) {
      const Reference next = pending.back();
      pending.pop_back();
      if (!next.openable()) {
        if (enter(next.id)) return true;
      } else if (accel::kdtree::may_meet(entry.ray, next.bounds(), limit())) {
        entry.instances->open(next, pending);
      }
    }
    return false;
  }

  /// Whether an instance is entered depends only on the ray and the instance's box, not on the cell
  /// that holds it.
  bool enter(std::uint32_t id) {
    const instances::Instance& instance = (*entry.instances)[id];
    const std::uint32_t index = entry.first + id;
    if ((instance.mask & ray.mask) == 0 || recent.contains_or_add(id)) return false;
    if (!is_seen(id, index)) return false;
    if (!accel::kdtree::may_meet(entry.ray, instance.box, limit())) return false;
    if (query.collects() && !caster.entered_.add(index)) return false;
    caster.enter_instance(ray, instance, index, *entry.built, query);
    return query.suspended || (query.any && query.found);
  }

  bool is_seen(std::uint32_t id, std::uint32_t index) const {
    if (entry.removed != nullptr && entry.removed->has(id)) return false;
    const Selection* selection = caster.options_.selection;
    return selection == nullptr || selection->selects(index);
  }
};

RayCaster::RayCaster(const instances::OpenTrees& trees, const TraceOptions& options)
    : trees_(trees),
      options_(options),
      on_deferred_(on_deferred(options.growth)),
      list_(std::size_t{options.max_hits} + 1) {
  static_entry_.instances = &trees_.static_tree;
  static_entry_.removed = trees_.removed;
  static_entry_.built = &built_;
  dynamic_entry_.instances = &trees_.dynamic_tree;
  dynamic_entry_.built = &built_dynamic_;
  dynamic_entry_.first = static_cast<std::uint32_t>(trees_.static_tree.size());
}

bool RayCaster::cast(const Ray& ray, accel::lazy::WhenPending when_pending, Hit& hit) {
  MeshQuery query;
  query.when_pending = when_pending;
  query.any = options_.kind == QueryKind::kAny;
  const Search searched = search(ray, query);
  if (searched == Search::kSuspended) return false;
  hit = Hit();
  if (searched == Search::kInvalid) {
    hit.t = std::numeric_limits<double>::quiet_NaN();
    hit.state = HitState::kInvalid;
    return true;
  }
  if (query.found) {
    set_hit(trees_[query.best_instance], ray, query.best_t, query.best_primitive,
            options_.surface && !query.any, hit);
  }
  hit.work = work_of(query);
  return true;
}

std::optional<RayTally> RayCaster::count(const Ray& ray, accel::lazy::WhenPending when_pending) {
  MeshQuery query;
  query.when_pending = when_pending;
  query.primitives = &primitives_;
  counted_ = 0;
  const Search searched = search(ray, query);
  if (searched == Search::kSuspended) return std::nullopt;
  if (searched == Search::kInvalid)
    return RayTally{.count = kInvalidCount, .state = HitState::kInvalid};
  stats_.hits_found += counted_;
  return RayTally{.count = static_cast<std::uint32_t>(std::min<std::uint64_t>(counted_, kMaxCount)),
                  .work = work_of(query),
                  .state = query.found ? HitState::kHit : HitState::kMiss};
}

/// Searches for one hit more than is kept: whether hits are cut off is then exact, and does not
/// depend on where the walk stops.
RayTally RayCaster::list(const Ray& ray, std::vector<Hit>& hits) {
  MeshQuery query;
  query.list = &list_;
  list_.clear();
  if (search(ray, query) == Search::kInvalid) return {.state = HitState::kInvalid};
  std::span<const accel::mesh::ListedHit> found = list_.sorted();
  RayTally tally{.work = work_of(query),
                 .state = query.found ? HitState::kHit : HitState::kMiss,
                 .cut_off = found.size() > options_.max_hits};
  if (tally.cut_off) {
    found = found.first(options_.max_hits);
    ++stats_.cut_off;
  }
  for (const accel::mesh::ListedHit& hit : found) {
    set_hit(trees_[hit.instance], ray, hit.t, hit.primitive, options_.surface, hits.emplace_back());
  }
  tally.count = static_cast<std::uint32_t>(found.size());
  stats_.hits_found += found.size();
  return tally;
}

RayCaster::Search RayCaster::search(const Ray& ray, MeshQuery& query) {
  ++stats_.rays;
  entered_.clear();
  frame_ = nullptr;
  work_before_ = walked_.steps + walked_.tests;
  if (!accel::geometry::set_local_ray(ray.origin - trees_.static_tree.center(), ray.direction,
                                      static_entry_.centered) ||
      std::isnan(ray.tmin) || std::isnan(ray.tmax)) {
    ++stats_.invalid;
    return Search::kInvalid;
  }
  query.tmin = ray.tmin;
  query.tmax = ray.tmax;
  query.on_deferred = on_deferred_;
  walk_trees(ray, query);
  if (query.suspended) {
    --stats_.rays;  // it is asked again
    progress_ = query.progress;
    return Search::kSuspended;
  }
  if (query.found) ++stats_.hits;
  return Search::kDone;
}

/// The tree that the ray enters first is walked first: its hits bound the walk of the other.
void RayCaster::walk_trees(const Ray& ray, MeshQuery& query) {
  for (const Entry* entry : trees_by_entry(ray)) {
    if (entry != nullptr && !query.suspended && !(query.any && query.found))
      walk_instances(ray, *entry, query);
  }
}

std::array<const RayCaster::Entry*, 2> RayCaster::trees_by_entry(const Ray& ray) {
  const bool in_static = trees_.static_tree.size() > 0 && enter_tree(ray, static_entry_);
  bool in_dynamic = false;
  if (trees_.dynamic_tree.size() > 0) {
    dynamic_entry_.centered.direction = static_entry_.centered.direction;
    dynamic_entry_.centered.unit = static_entry_.centered.unit;
    in_dynamic = accel::geometry::set_local_origin(ray.origin - trees_.dynamic_tree.center(),
                                                   dynamic_entry_.centered) &&
                 enter_tree(ray, dynamic_entry_);
  }
  const Entry* in_order[] = {in_static ? &static_entry_ : nullptr,
                             in_dynamic ? &dynamic_entry_ : nullptr};
  const bool dynamic_first = in_static && in_dynamic &&
                             dynamic_entry_.ray.t_in * dynamic_entry_.centered.unit <
                                 static_entry_.ray.t_in * static_entry_.centered.unit;
  if (dynamic_first) std::swap(in_order[0], in_order[1]);
  return {in_order[0], in_order[1]};
}

bool RayCaster::enter_tree(const Ray& ray, Entry& entry) {
  return accel::kdtree::enter(entry.centered, entry.instances->tree().tree().bounds(),
                              ray.tmin / entry.centered.unit, ray.tmax / entry.centered.unit,
                              entry.ray);
}

void RayCaster::walk_instances(const Ray& ray, const Entry& entry, MeshQuery& query) {
  accel::lazy::LazyTree& tree = entry.instances->tree();
  Visit visit{*this, ray, entry, query, {}};
  accel::kdtree::walk(tree.tree(), entry.ray, tree.root(), walked_, visit);
}

std::uint32_t RayCaster::work_of(const MeshQuery& query) const {
  const std::uint64_t work = walked_.steps + walked_.tests - work_before_;
  return static_cast<std::uint32_t>(
             std::min<std::uint64_t>(work, accel::geometry::kWorkDeferred - 1)) |
         (query.saw_deferred ? accel::geometry::kWorkDeferred : 0);
}

void RayCaster::enter_instance(const Ray& ray, const instances::Instance& instance,
                               std::uint32_t index, accel::kdtree::BuildCounters& built,
                               MeshQuery& query) {
  // Most instances of a scene share a few frames.
  if (frame_ == nullptr || *frame_ != instance.local_from_world) {
    frame_ = &instance.local_from_world;
    in_frame_ = accel::geometry::set_local_ray(frame_->point(ray.origin),
                                               frame_->direction(ray.direction), query.ray);
  }
  if (!in_frame_) return;
  ++stats_.instances_entered;
  if (query.on_deferred != OnDeferred::kSkip &&
      !instance.entered->load(std::memory_order_relaxed)) {
    instance.entered->store(true, std::memory_order_relaxed);
  }
  query.node = instance.node;
  query.instance = index;
  query.culling = instance.mirrored ? turned(options_.culling) : options_.culling;
  if (query.primitives != nullptr) query.primitives->clear();
  instance.mesh->tree().query(query, walked_, built);
  if (query.primitives != nullptr) counted_ += query.primitives->sorted().size();
}

TraceStats RayCaster::stats() const {
  TraceStats stats = stats_;
  stats.traversal_steps = walked_.steps;
  stats.triangle_tests = walked_.tests;
  stats.cells_expanded = built_.cells_expanded + built_dynamic_.cells_expanded;
  stats.touches = built_.touches + built_dynamic_.touches;
  stats.touches_prepare = built_.touches_prepare + built_dynamic_.touches_prepare;
  stats.dynamic_touches = built_dynamic_.touches + built_dynamic_.touches_prepare;
  stats.build_seconds = built_.seconds + built_dynamic_.seconds;
  return stats;
}

}  // namespace sightline::scenegraph::query
