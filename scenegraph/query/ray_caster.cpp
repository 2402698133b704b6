// The steps of one ray, and its answer.
#include "scenegraph/query/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "accel/mesh/mesh_tree.h"
#include "scenegraph/query/on_deferred.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/query/surface.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::mesh::ListedHit;
using accel::mesh::OnDeferred;

}  // namespace

RayCaster::RayCaster(accel::kdtree::EpochPin& pin, const instances::OpenTrees& trees,
                     const TraceOptions& options)
    : pin_(pin), trees_(trees), options_(options), collected_(options.max_hits) {
  for (const instances::OpenTree& tree : trees_.all()) {
    TreeEntry& entry = entries_.emplace_back();
    entry.instances = &tree.instances;
    entry.removed = tree.removed;
    entry.first = static_cast<std::uint32_t>(tree.first);
    entry.built = entries_.size() == 1 ? &counters_.static_built : &counters_.dynamic_built;
  }
}

void RayCaster::begin(QueryKind kind, const Ray& ray, accel::lazy::WhenPending when_pending) {
  pin_.renew();
  ++stats_.rays;
  ray_ = &ray;
  query_ = {};
  query_.waiting = waiting_;
  query_.on_deferred = waiting_ != nullptr ? OnDeferred::kWait : on_deferred(options_.growth);
  query_.when_pending = when_pending;
  query_.pin = &pin_;
  query_.cancelled = options_.cancelled;
  query_.tmin = ray.tmin;
  query_.tmax = ray.tmax;
  query_.any = kind == QueryKind::kAny;
  query_.culling = options_.culling;
  static_cast<accel::mesh::HitSinks&>(query_) = collected_.begin(kind);
  frame_ = nullptr;
  work_before_ = counters_.walked.steps + counters_.walked.tests;
  // The static tree's center is finite even if the tree is empty.
  valid_ = accel::geometry::set_local_ray(ray.origin - trees_.static_tree().center(), ray.direction,
                                          entries_.front().centered) &&
           !std::isnan(ray.tmin) && !std::isnan(ray.tmax);
}

std::span<TreeEntry* const> RayCaster::trees_by_entry() {
  by_entry_.clear();
  if (!valid_) return {};
  const accel::geometry::LocalRay& centered = entries_.front().centered;
  for (TreeEntry& entry : entries_) {
    if (entry.instances->size() == 0) continue;
    // The trees differ in their centers alone.
    entry.centered.direction = centered.direction;
    entry.centered.unit = centered.unit;
    if ((&entry == &entries_.front() ||
         accel::geometry::set_local_origin(ray_->origin - entry.instances->center(),
                                           entry.centered)) &&
        enter_bounds(entry)) {
      entry.entered_at = entry.ray.t_in * entry.centered.unit;
      by_entry_.push_back(&entry);
    }
  }
  std::stable_sort(by_entry_.begin(), by_entry_.end(), [](const TreeEntry* a, const TreeEntry* b) {
    return a->entered_at < b->entered_at;
  });
  return by_entry_;
}

bool RayCaster::enter_bounds(TreeEntry& tree) const {
  return accel::kdtree::enter(tree.centered, tree.instances->tree().tree().bounds(),
                              ray_->tmin / tree.centered.unit, ray_->tmax / tree.centered.unit,
                              tree.ray);
}

bool RayCaster::is_seen(const TreeEntry& tree, std::uint32_t id) const {
  if (tree.removed != nullptr && tree.removed->has(id)) return false;
  return options_.selection == nullptr || options_.selection->selects(tree.first + id);
}

bool RayCaster::enter_frame(const instances::Instance& instance) {
  // Most instances of a scene share a few frames.
  if (frame_ == nullptr || *frame_ != instance.local_from_world) {
    frame_ = &instance.local_from_world;
    in_frame_ = accel::geometry::set_local_ray(frame_->point(ray_->origin),
                                               frame_->direction(ray_->direction), query_.ray);
  }
  return in_frame_;
}

void RayCaster::ask_mesh(const instances::Instance& instance, TreeEntry& tree) {
  ++stats_.instances_entered;
  if (query_.on_deferred == OnDeferred::kSkip && !instance.mesh->is_resident()) {
    query_.saw_deferred = true;
    return;
  }
  if (query_.on_deferred != OnDeferred::kSkip && !instance.entered->load(std::memory_order_relaxed))
    instance.entered->store(true, std::memory_order_relaxed);
  query_.node = instance.node;
  query_.instance = tree.first + instance.index;
  model::Mesh::OwnedTree& mesh = instance.mesh->owned_tree();
  const accel::lazy::OwnedTree owned(query_, mesh);
  mesh.tree.query(query_, counters_.walked, *tree.built);
  if (query_.primitives != nullptr && query_.found) collected_.end_mesh();
}

bool RayCaster::end() {
  if (!valid_) {
    ++stats_.invalid;
  } else if (query_.suspended || query_.is_cancelled()) {
    --stats_.rays;  // it has no answer yet
    return false;
  } else if (query_.found) {
    ++stats_.hits;
  }
  return true;
}

std::uint32_t RayCaster::work() const {
  const std::uint64_t work = counters_.walked.steps + counters_.walked.tests - work_before_;
  return static_cast<std::uint32_t>(
             std::min<std::uint64_t>(work, accel::geometry::kWorkDeferred - 1)) |
         (query_.saw_deferred ? accel::geometry::kWorkDeferred : 0);
}

Hit RayCaster::hit() const {
  Hit hit;
  if (!valid_) {
    hit.t = std::numeric_limits<double>::quiet_NaN();
    hit.state = HitState::kInvalid;
    return hit;
  }
  if (query_.found)
    hit = hit_of({query_.best_t, query_.best_node, query_.best_primitive, query_.best_instance});
  hit.work = work();
  return hit;
}

RayTally RayCaster::tally() const {
  if (!valid_) return {.state = HitState::kInvalid};
  return {.work = work(), .state = query_.found ? HitState::kHit : HitState::kMiss};
}

RayTally RayCaster::count() {
  RayTally answer = tally();
  answer.count = valid_ ? collected_.count(stats_) : kInvalidCount;
  return answer;
}

RayTally RayCaster::list(std::vector<Hit>& hits) {
  RayTally answer = tally();
  if (!valid_) return answer;
  const std::span<const ListedHit> found = collected_.list(stats_, answer.cut_off);
  for (const ListedHit& listed : found) hits.push_back(hit_of(listed));
  answer.count = static_cast<std::uint32_t>(found.size());
  return answer;
}

Hit RayCaster::hit_of(const ListedHit& listed) const {
  return query::hit_of(listed, trees_, *ray_, options_.surface && !query_.any);
}

TraceStats RayCaster::stats() const {
  TraceStats stats = stats_;
  counters_.add_to(stats);
  return stats;
}

}  // namespace sightline::scenegraph::query
