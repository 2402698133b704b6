// The scene level of a ray's way.
#include "scenegraph/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenegraph/selection.h"
#include "scenegraph/surface.h"

namespace sightline::scenegraph {
namespace {

using accel::AtUnbuilt;
using accel::BoxRef;
using accel::Hit;
using accel::HitState;
using accel::MeshQuery;
using accel::Ray;

AtUnbuilt at_unbuilt(Growth growth) {
  switch (growth) {
    case Growth::kNone:
      return AtUnbuilt::kSearch;
    case Growth::kBuiltOnly:
      return AtUnbuilt::kSkip;
    case Growth::kFirstTouch:
    case Growth::kFull:
      break;
  }
  return AtUnbuilt::kExpand;
}

}  // namespace

/// What a walk of the scene's tree asks at its leaves and unbuilt cells.
struct RayCaster::Visit {
  RayCaster& caster;
  const Ray& ray;
  const accel::LocalRay& centered;
  const accel::TreeRay& scene_ray;
  MeshQuery& query;
  RecentlyEntered recent;

  double limit() const { return query.best_t / centered.unit + scene_ray.slack; }

  bool leaf(std::span<const std::uint32_t> ids) {
    for (const std::uint32_t id : ids) {
      if (enter(id)) return true;
    }
    return false;
  }

  accel::Unbuilt unbuilt(accel::AtomicSlot& slot, const accel::DeferredCell& cell) {
    if (query.at_unbuilt == AtUnbuilt::kExpand) {
      const accel::Expanded expanded =
          caster.instances_.tree().expand(slot, query.at_busy, caster.built_);
      if (expanded == accel::Expanded::kAgain) return accel::Unbuilt::kAgain;
      if (expanded == accel::Expanded::kBusy) {
        query.put_aside = true;
        query.progress = accel::LazyTree::progress(slot);
        return accel::Unbuilt::kStop;
      }
    }
    query.met_unbuilt = true;
    if (query.at_unbuilt == AtUnbuilt::kSkip) return accel::Unbuilt::kDone;
    return search(cell) ? accel::Unbuilt::kStop : accel::Unbuilt::kDone;
  }

  bool search(const accel::DeferredCell& cell) {
    if (cell.listed)
      return cell.list.any_part([&](std::span<const BoxRef> refs) { return search(refs); });
    return search(caster.instances_.coarsest());
  }

  bool search(std::span<const BoxRef> refs) {
    return std::any_of(refs.begin(), refs.end(), [&](const BoxRef& ref) {
      return ref.openable() ? search_below(ref) : enter(ref.id);
    });
  }

  /// Through what the ray may meet of the hierarchy.
  bool search_below(const BoxRef& ref) {
    std::vector<BoxRef>& waiting = caster.waiting_;
    waiting.assign(1, ref);
    while (!waiting.empty()) {
      const BoxRef next = waiting.back();
      waiting.pop_back();
      if (!next.openable()) {
        if (enter(next.id)) return true;
      } else if (accel::may_meet(scene_ray, next.bounds(), limit())) {
        caster.instances_.open(next, waiting);
      }
    }
    return false;
  }

  /// Whether an instance is entered depends on the ray and its box alone, not on the cell that led
  /// here.
  bool enter(std::uint32_t id) {
    const Instance& instance = caster.instances_[id];
    if ((instance.mask & ray.mask) == 0 || recent.contains_or_add(id)) return false;
    if (caster.options_.selection != nullptr && !caster.options_.selection->selects(id))
      return false;
    if (!accel::may_meet(scene_ray, instance.box, limit())) return false;
    if (query.collects() && !caster.entered_.add(id)) return false;
    caster.enter_instance(ray, id, query);
    return query.put_aside || (query.any && query.found);
  }
};

RayCaster::RayCaster(const Instances& instances, const TraceOptions& options)
    : instances_(instances),
      options_(options),
      at_unbuilt_(at_unbuilt(options.growth)),
      list_(std::size_t{options.max_hits} + 1) {}

bool RayCaster::cast(const Ray& ray, accel::AtBusy at_busy, Hit& hit) {
  MeshQuery query;
  query.at_busy = at_busy;
  query.any = options_.kind == QueryKind::kAny;
  const Search searched = search(ray, query);
  if (searched == Search::kPutAside) return false;
  hit = Hit();
  if (searched == Search::kInvalid) {
    hit.t = std::numeric_limits<double>::quiet_NaN();
    hit.state = HitState::kInvalid;
    return true;
  }
  if (query.found) {
    set_hit(instances_[query.best_instance], ray, query.best_t, query.best_primitive,
            options_.surface && !query.any, hit);
  }
  hit.work = work_of(query);
  return true;
}

std::optional<RayTally> RayCaster::count(const Ray& ray, accel::AtBusy at_busy) {
  MeshQuery query;
  query.at_busy = at_busy;
  query.primitives = &primitives_;
  counted_ = 0;
  const Search searched = search(ray, query);
  if (searched == Search::kPutAside) return std::nullopt;
  if (searched == Search::kInvalid)
    return RayTally{.count = kInvalidCount, .state = HitState::kInvalid};
  stats_.hits_found += counted_;
  return RayTally{.count = static_cast<std::uint32_t>(std::min<std::uint64_t>(counted_, kMaxCount)),
                  .work = work_of(query),
                  .state = query.found ? HitState::kHit : HitState::kMiss};
}

/// One more than may be kept is looked for: whether there is one is then known exactly, and does
/// not depend on where the walk has stopped.
RayTally RayCaster::list(const Ray& ray, std::vector<Hit>& hits) {
  MeshQuery query;
  query.list = &list_;
  list_.clear();
  if (search(ray, query) == Search::kInvalid) return {.state = HitState::kInvalid};
  std::span<const accel::ListedHit> found = list_.sorted();
  RayTally tally{.work = work_of(query),
                 .state = query.found ? HitState::kHit : HitState::kMiss,
                 .cut_off = found.size() > options_.max_hits};
  if (tally.cut_off) {
    found = found.first(options_.max_hits);
    ++stats_.cut_off;
  }
  for (const accel::ListedHit& hit : found) {
    set_hit(instances_[hit.instance], ray, hit.t, hit.primitive, options_.surface,
            hits.emplace_back());
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
  accel::LocalRay centered;
  if (!accel::set_local_ray(ray.origin - instances_.center(), ray.direction, centered) ||
      std::isnan(ray.tmin) || std::isnan(ray.tmax)) {
    ++stats_.invalid;
    return Search::kInvalid;
  }
  query.tmin = ray.tmin;
  query.tmax = ray.tmax;
  query.at_unbuilt = at_unbuilt_;
  accel::TreeRay scene_ray;
  accel::LazyTree& tree = instances_.tree();
  if (instances_.size() > 0 &&
      accel::enter(centered, tree.tree().bounds(), ray.tmin / centered.unit,
                   ray.tmax / centered.unit, scene_ray)) {
    Visit visit{*this, ray, centered, scene_ray, query, {}};
    accel::walk(tree.tree(), scene_ray, tree.root(), walked_, visit);
  }
  if (query.put_aside) {
    --stats_.rays;  // it comes again
    progress_ = query.progress;
    return Search::kPutAside;
  }
  if (query.found) ++stats_.hits;
  return Search::kDone;
}

std::uint32_t RayCaster::work_of(const MeshQuery& query) const {
  const std::uint64_t work = walked_.steps + walked_.tests - work_before_;
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(work, accel::kWorkUnbuilt - 1)) |
         (query.met_unbuilt ? accel::kWorkUnbuilt : 0);
}

void RayCaster::enter_instance(const Ray& ray, std::uint32_t index, MeshQuery& query) {
  const Instance& instance = instances_[index];
  // Most instances of a scene share a few frames.
  if (frame_ == nullptr || *frame_ != instance.local_from_world) {
    frame_ = &instance.local_from_world;
    in_frame_ = accel::set_local_ray(frame_->point(ray.origin), frame_->direction(ray.direction),
                                     query.ray);
  }
  if (!in_frame_) return;
  ++stats_.instances_entered;
  if (query.at_unbuilt != AtUnbuilt::kSkip && !instance.entered->load(std::memory_order_relaxed)) {
    instance.entered->store(true, std::memory_order_relaxed);
  }
  query.node = instance.node;
  query.instance = index;
  query.culling = instance.mirrored ? turned(options_.culling) : options_.culling;
  if (query.primitives != nullptr) query.primitives->clear();
  instance.mesh->tree().query(query, walked_, built_);
  if (query.primitives != nullptr) counted_ += query.primitives->sorted().size();
}

TraceStats RayCaster::stats() const {
  TraceStats stats = stats_;
  stats.traversal_steps = walked_.steps;
  stats.triangle_tests = walked_.tests;
  stats.cells_expanded = built_.cells_expanded;
  stats.touches = built_.touches;
  stats.touches_prepare = built_.touches_prepare;
  stats.build_seconds = built_.seconds;
  return stats;
}

}  // namespace sightline::scenegraph
