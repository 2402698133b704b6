#include "scenegraph/query/caster.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "accel/lazy/growing_leaf.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/exact.h"
#include "scenegraph/query/instance_tests.h"
#include "scenegraph/query/surface.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitColumns;
using accel::geometry::HitState;
using accel::geometry::kInfinity;
using accel::geometry::RayColumns;
using accel::wide::Goal;
using accel::wide::kLanes;

Goal goal(QueryKind kind) {
  switch (kind) {
    case QueryKind::kAny:
      return Goal::kAny;
    case QueryKind::kCount:
    case QueryKind::kAll:
      return Goal::kEvery;
    case QueryKind::kClosest:
      break;
  }
  return Goal::kNearest;
}

}  // namespace

Caster::Caster(accel::kdtree::EpochPin& pin, const instances::OpenTrees& trees, QueryKind kind,
               const TraceOptions& options)
    : pin_(pin),
      trees_(trees),
      flat_(trees.static_tree().flat()),
      kind_(kind),
      options_(options),
      collected_(kind == QueryKind::kCount || kind == QueryKind::kAll ? kLanes : 0,
                 Collected(options.max_hits)) {
  for (accel::wide::Packet* packet : {&scene_, &mesh_}) {
    packet->best = &best_;
    packet->goal = goal(kind);
    packet->points = options.points ? &given_ : nullptr;
    packet->cancelled = options.cancelled;
    packet->from_origin = options.from_origin;
  }
  if (!options.points) scene_.culling = mesh_.culling = options.culling;
  mesh_.scene_from_local = &world_from_local_.m;
  mesh_.sinks = std::span(sinks_).first(collected_.size());
  scene_.sinks = std::span(flat_sinks_).first(collected_.size());
}

void Caster::read() {
  accel::wide::read(*rays_, packet_.first, packet_.count, given_);
  for (accel::wide::Packet* packet : {&scene_, &mesh_}) {
    packet->work.fill(0);
    packet->saw_deferred = packet->suspended = 0;
    packet->stopped = false;
  }
  masks_.read(rays_->mask, packet_);
  // Columns with one number for all points.
  scene_.near.alike = mesh_.near.alike =
      rays_->mask.stride == 0 && rays_->tmax.stride == 0 && rays_->tmax[0] == kInfinity;
  best_.clear();
  valid_ = accel::wide::valid(given_, trees_.static_tree().center(), packet_.lanes);
  frame_ = nullptr;
  cells_ = {};
  cells_.growth = options_.growth;
  cells_.pin = &pin_;
  cells_.cancelled = options_.cancelled;
  for (std::size_t i = 0; i < collected_.size(); ++i) {
    sinks_[i] = collected_[i].begin(kind_);
    flat_sinks_[i] = collected_[i].sink_of_flat(kind_);
  }
}

std::uint32_t Caster::cast(const RayColumns& rays, const RayPacket& packet, bool waits) {
  pin_.renew();
  rays_ = &rays;
  packet_ = packet;
  read();
  cells_.waits = waits;
  cells_.samples = samples_;
  const std::uint64_t before = entries_;
  walk_static(trees_.all().front(), counters_.static_built);
  static_entries_ += entries_ - before;
  for (const instances::OpenTree& tree : trees_.dynamic()) {
    if (tree.instances.size() > 0)
      walk_tree(tree, tree.instances.tree(), scene_.left(valid_), counters_.dynamic_built);
  }
  if (scene_.suspended != 0 || scene_.stopped) progress_ = cells_.progress;
  return scene_.stopped || cells_.is_cancelled() ? 0 : end();
}

std::optional<Arrival> Caster::first_deferred_cell(const RayColumns& rays, std::size_t ray) {
  samples_ = true;
  cast(rays, {ray, 1}, /*waits=*/true);
  return std::exchange(arrival_, std::nullopt);
}

std::uint32_t Caster::end() {
  stats_.rays += static_cast<std::uint64_t>(std::popcount(answered()));
  stats_.invalid += static_cast<std::uint64_t>(std::popcount(answered() & ~valid_));
  stats_.hits += static_cast<std::uint64_t>(std::popcount(answered() & best_.found));
  return answered();
}

/// Takes rays through a tree over instances of `tree`.
void Caster::walk_tree(const instances::OpenTree& tree, accel::lazy::LazyTree& kd,
                       std::uint32_t lanes, accel::kdtree::BuildCounters& built) {
  if (lanes == 0 || kd.tree().bounds().empty()) return;
  InstanceTests content(*this, tree, kd.frame(), built);
  if (const auto only = kd.only()) return content.visit_only(*only, lanes);
  lanes = accel::wide::center(given_, tree.instances.center(), lanes, scene_.rays);
  lanes = accel::wide::prepare(scene_, kd.frame(), lanes);
  accel::lazy::GrowingLeaf(kd, scene_, cells_, counters_.walked, built, content).walk(lanes);
}

namespace {

/// The rays whose directions are neither so short nor so long that they may be out of range in the
/// frame of a flat instance.
std::uint32_t ordinary(const accel::wide::Rays& rays, std::uint32_t lanes) {
  std::uint32_t in_range = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const double unit = rays.unit[lane];
    in_range |= static_cast<std::uint32_t>(unit >= 0x1p-800 && unit <= 0x1p+800) << lane;
  }
  return lanes & in_range;
}

}  // namespace

void Caster::walk_static(const instances::OpenTree& tree, accel::kdtree::BuildCounters& built) {
  if (tree.instances.size() == 0) return;
  std::uint32_t lanes = scene_.left(valid_);
  if (flat_ != nullptr) {
    lanes = accel::wide::center(given_, tree.instances.center(), lanes, scene_.rays);
    const std::uint32_t flat = ordinary(scene_.rays, lanes);
    walk_flat(tree, flat);
    if (flat_->entered() != nullptr) walk_tree(tree, *flat_->entered(), scene_.left(flat), built);
    lanes = scene_.left(lanes & ~flat);
  }
  walk_tree(tree, tree.instances.tree(), lanes, built);
}

namespace {

/// What is asked of an instance in a flat tree.
struct Seen {
  const instances::OpenTree& tree;
  const Selection* selection;
  const Masks& masks;

  static std::uint32_t seeing(const void* asked, const accel::wide::PlacedMesh& mesh,
                              std::uint32_t lanes) {
    const Seen& seen = *static_cast<const Seen*>(asked);
    lanes = seen.masks.seeing(seen.tree.instances[mesh.instance].mask, lanes);
    return lanes != 0 && is_seen(seen.tree, mesh.instance, seen.selection) ? lanes : 0;
  }
};

/// The leaf policy of a tree that ends in blocks everywhere.
struct AllBlocks {
  accel::wide::Child enter(accel::kdtree::AtomicSlot&, std::uint32_t) { return {}; }
  void visit(std::span<const std::uint32_t>, std::uint32_t) {}
};

}  // namespace

/// Takes rays that are centered through the triangles of flat instances.
void Caster::walk_flat(const instances::OpenTree& tree, std::uint32_t lanes) {
  const accel::mesh::FlatTree& flat = flat_->triangles();
  lanes = accel::wide::prepare(scene_, flat.frame(), lanes);
  if (lanes == 0) return;
  const Seen seen{tree, options_.selection, masks_};
  const accel::wide::Visibility visible{&Seen::seeing, &seen};
  const bool filters =
      tree.removed != nullptr || options_.selection != nullptr || !masks_.see_all();
  scene_.placed = flat.meshes();
  scene_.placed.given = &given_;
  scene_.placed.visible = filters ? &visible : nullptr;
  scene_.placed.first_instance = static_cast<std::uint32_t>(tree.first);
  AllBlocks leaf;
  accel::wide::walk(scene_, flat.root(), lanes, accel::wide::Leaf(leaf), counters_.walked);
  if (scene_.goal == Goal::kNearest) accel::wide::resolve(scene_, scene_.live);
  scene_.placed = {};
}

void Caster::enter(const instances::Instances& tree, const instances::Instance& instance,
                   std::uint32_t index, std::uint32_t lanes, accel::kdtree::BuildCounters& built) {
  if (frame_ == nullptr || *frame_ != instance.local_from_world) {
    frame_ = &instance.local_from_world;
    in_frame_ = accel::wide::transform(given_, frame_->m, valid_, mesh_.rays);
  }
  if (options_.points) {
    world_from_local_ = tree.world_from_local(instance);
    mesh_.local_from_scene = &frame_->m;
  } else {
    lanes &= in_frame_;
  }
  if (lanes == 0) return;
  ++entries_;
  stats_.instances_entered += static_cast<std::uint64_t>(std::popcount(lanes));
  if (options_.growth == Growth::kBuiltOnly) {
    if (!instance.mesh->is_resident()) {
      scene_.saw_deferred |= lanes;
      return;
    }
  } else {
    instance.mark_entered();
  }
  mesh_.node = instance.node;
  mesh_.instance = index;
  model::Mesh::OwnedTree& mesh = instance.mesh->owned_tree();
  const accel::lazy::OwnedTree owned(cells_, mesh);
  mesh.tree.query(mesh_, lanes, cells_, counters_.walked, built);
  if (cells_.awaited.tree != nullptr) {
    mesh.join();
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    arrival_ = {cells_.awaited, decltype(Arrival::owner)(&mesh), ray_of(mesh_.rays, lane)};
  }
  scene_.stopped |= mesh_.stopped;
  if (kind_ != QueryKind::kCount || mesh_.stopped) return;
  for (std::uint32_t hit = lanes & best_.found; hit != 0; hit &= hit - 1)
    collected_[static_cast<std::size_t>(std::countr_zero(hit))].end_mesh();
}

std::uint32_t Caster::entering(std::uint32_t index, std::uint32_t lanes) {
  for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    if (!collected_[lane].enter(index)) lanes &= ~(1u << lane);
  }
  return lanes;
}

HitState Caster::state(std::size_t lane) const {
  if ((valid_ >> lane & 1) == 0) return HitState::kInvalid;
  return (best_.found >> lane & 1) != 0 ? HitState::kHit : HitState::kMiss;
}

std::uint32_t Caster::work(std::size_t lane) const {
  if ((valid_ >> lane & 1) == 0) return 0;
  const std::uint32_t work =
      std::min(scene_.work[lane] + mesh_.work[lane], accel::geometry::kWorkDeferred - 1);
  const bool deferred = ((scene_.saw_deferred | mesh_.saw_deferred) >> lane & 1) != 0;
  return work | (deferred ? accel::geometry::kWorkDeferred : 0);
}

RayTally Caster::count(std::size_t lane) {
  RayTally tally{.work = work(lane), .state = state(lane)};
  if (tally.state == HitState::kInvalid) tally.count = kInvalidCount;
  if (tally.state == HitState::kHit) tally.count = collected_[lane].count(stats_);
  return tally;
}

RayTally Caster::list(std::size_t lane, std::vector<Hit>& hits) {
  RayTally tally{.work = work(lane), .state = state(lane)};
  if (tally.state != HitState::kHit) return tally;
  const accel::geometry::Ray given = (*rays_)[packet_.first + lane];
  const std::span<const accel::wide::ListedHit> found =
      collected_[lane].list(stats_, tally.cut_off);
  for (const accel::wide::ListedHit& listed : found) {
    Hit& hit = hits.emplace_back(hit_of(listed));
    if (options_.surface) set_surface(trees_, listed.instance, options_.points, given, hit);
  }
  tally.count = static_cast<std::uint32_t>(found.size());
  return tally;
}

void Caster::write(const HitColumns& hits) {
  for (std::size_t i = 0; i < kLanes; ++i) scene_.work[i] += mesh_.work[i];
  const bool any = kind_ == QueryKind::kAny;
  const accel::wide::Outcome outcome{
      best_, scene_.work, answered(), valid_, scene_.saw_deferred | mesh_.saw_deferred, any};
  accel::wide::write(outcome, hits, packet_.first);
  // Once the pin was renewed, the blocks of hits may be gone: weights come from the mesh's arrays.
  if (options_.surface && !any)
    write_surfaces({given_, outcome, packet_.first, !cells_.renewed, options_.points}, trees_,
                   *rays_, hits);
}

TraceStats Caster::stats() const {
  TraceStats stats = stats_;
  counters_.add_to(stats);
  return stats;
}

}  // namespace sightline::scenegraph::query
