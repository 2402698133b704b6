#include "scenegraph/query/packet_caster.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/mesh_tree.h"
#include "scenegraph/query/on_deferred.h"
#include "scenegraph/query/packet_hits.h"
#include "scenegraph/query/scene_slots.h"
#include "scenegraph/query/surface.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitColumns;
using accel::geometry::HitState;
using accel::geometry::RayColumns;
using accel::wide::kLanes;

std::uint32_t first_lanes(std::size_t count) {
  return static_cast<std::uint32_t>((std::uint64_t{1} << count) - 1);
}

}  // namespace

PacketCaster::PacketCaster(accel::kdtree::EpochPin& pin, const instances::OpenTrees& trees,
                           QueryKind kind, const TraceOptions& options)
    : pin_(pin),
      trees_(trees),
      kind_(kind),
      options_(options),
      collected_(kind == QueryKind::kCount || kind == QueryKind::kAll ? kLanes : 0,
                 Collected(options.max_hits)) {
  for (accel::wide::Packet* packet : {&scene_, &mesh_}) {
    packet->best = &best_;
    packet->any = kind == QueryKind::kAny;
  }
  mesh_.culling = options.culling;
}

void PacketCaster::read_masks() {
  const accel::geometry::MaskColumn& column = rays_->mask;
  if (column.stride == 0) {
    masks_.fill(column[0]);
    see_all_ = masks_[0] == accel::geometry::kAllMasks;
    return;
  }
  std::uint32_t all = accel::geometry::kAllMasks;
  for (std::size_t i = 0; i < kLanes; ++i) {
    masks_[i] = column[range_.first + std::min(i, range_.count - 1)];
    all &= masks_[i];
  }
  see_all_ = all == accel::geometry::kAllMasks;
}

void PacketCaster::read() {
  accel::wide::read(*rays_, range_.first, range_.count, given_);
  for (accel::wide::Packet* packet : {&scene_, &mesh_}) {
    packet->work.fill(0);
    packet->stopped = false;
  }
  read_masks();
  best_.clear();
  valid_ = accel::wide::valid(given_, trees_.static_tree().center(), first_lanes(range_.count));
  alone_ = saw_deferred_ = 0;
  renewed_ = false;
  frame_ = nullptr;
  lazy_ = {};
  lazy_.on_deferred = on_deferred(options_.growth);
  lazy_.when_pending = accel::lazy::WhenPending::kReturn;
  lazy_.pin = &pin_;
  lazy_.cancelled = options_.cancelled;
  for (std::size_t i = 0; i < collected_.size(); ++i) sinks_[i] = collected_[i].begin(kind_);
}

std::uint32_t PacketCaster::cast(const RayColumns& rays, PacketRange range) {
  pin_.renew();
  rays_ = &rays;
  range_ = range;
  read();
  for (const instances::OpenTree& tree : trees_.all()) {
    if (scene_.stopped) break;
    if (tree.instances.size() > 0)
      walk_tree(tree,
                &tree == &trees_.all().front() ? counters_.static_built : counters_.dynamic_built);
  }
  return scene_.stopped || lazy_.is_cancelled() ? 0 : end();
}

std::uint32_t PacketCaster::end() {
  const std::uint32_t answered = first_lanes(range_.count) & ~alone_;
  stats_.rays += static_cast<std::uint64_t>(std::popcount(answered));
  stats_.invalid += static_cast<std::uint64_t>(std::popcount(answered & ~valid_));
  stats_.hits += static_cast<std::uint64_t>(std::popcount(answered & best_.found));
  return answered;
}

void PacketCaster::walk_tree(const instances::OpenTree& tree, accel::kdtree::BuildCounters& built) {
  accel::lazy::LazyTree& kd = tree.instances.tree();
  if (kd.tree().bounds().empty()) return;
  const std::uint32_t lanes = left_to_cast(valid_);
  if (lanes == 0) return;
  if (!kd.frame()) {
    alone_ |= lanes;
    return;
  }
  SceneSlots slots(*this, tree, built);
  const accel::kdtree::Slot root = accel::kdtree::load(kd.root());
  if (root.is_leaf() && root.leaf_count() == 1) return slots.visit_only(root.leaf_first(), lanes);
  const std::uint32_t in_range =
      accel::wide::center(given_, tree.instances.center(), lanes, scene_.rays);
  alone_ |= lanes & ~in_range;
  const accel::wide::Prepared prepared = accel::wide::prepare(scene_, *kd.frame(), in_range);
  alone_ |= prepared.slow;
  if (tree.instances.is_searched()) return slots.search_all(prepared.live);
  accel::wide::WalkTotals totals;
  const accel::wide::Child entry = kd.entry();
  lazy_.searches_list = entry.is_node();  // no renewing of the pin while the walk is in these nodes
  accel::wide::walk(scene_, entry, prepared.live, slots, totals);
  lazy_.searches_list = false;
  counters_.walked.steps += totals.nodes;
}

std::uint32_t PacketCaster::left_to_cast(std::uint32_t lanes) const {
  return lanes & ~alone_ & ~(scene_.any ? best_.found : 0);
}

std::uint32_t PacketCaster::seeing(std::uint32_t mask, std::uint32_t lanes) const {
  if (see_all_) return mask != 0 ? lanes : 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    if ((masks_[i] & mask) == 0) lanes &= ~(1u << i);
  }
  return lanes;
}

void PacketCaster::enter(const instances::Instance& instance, std::uint32_t index,
                         std::uint32_t lanes, accel::kdtree::BuildCounters& built) {
  if (frame_ == nullptr || *frame_ != instance.local_from_world) {
    frame_ = &instance.local_from_world;
    in_frame_ = accel::wide::carry(given_, frame_->m, valid_, mesh_.rays);
  }
  lanes &= in_frame_;
  if (!collected_.empty() && leads_) lanes = entering(index, lanes);
  if (lanes == 0) return;
  stats_.instances_entered += static_cast<std::uint64_t>(std::popcount(lanes));
  if (lazy_.on_deferred == accel::lazy::OnDeferred::kSkip && !instance.mesh->is_resident()) {
    saw_deferred_ |= lanes;
    return;
  }
  if (lazy_.on_deferred != accel::lazy::OnDeferred::kSkip &&
      !instance.entered->load(std::memory_order_relaxed))
    instance.entered->store(true, std::memory_order_relaxed);
  mesh_.node = instance.node;
  mesh_.instance = index;
  model::Mesh::OwnedTree& mesh = instance.mesh->owned_tree();
  const accel::lazy::OwnedTree owned(lazy_, mesh);
  mesh.tree.query(
      mesh_, lanes,
      {lazy_, saw_deferred_, counters_.walked, built, std::span(sinks_).first(collected_.size())});
  renewed_ |= lazy_.joined;
  if (mesh_.stopped) {
    scene_.stopped = true;
    return;
  }
  if (scene_.any) return;
  for (std::uint32_t hit = lanes & best_.found; hit != 0; hit &= hit - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(hit));
    if (kind_ == QueryKind::kCount) {
      collected_[lane].end_mesh();
    } else if (leads_ && (kind_ == QueryKind::kAll || best_.instance[lane] == index) &&
               best_.t[lane] < std::numeric_limits<double>::max()) {
      accel::wide::tighten(scene_, lane);  // not for a list that is not full
    }
  }
}

std::uint32_t PacketCaster::entering(std::uint32_t index, std::uint32_t lanes) {
  for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    if (!collected_[lane].enter(index)) lanes &= ~(1u << lane);
  }
  return lanes;
}

HitState PacketCaster::state(std::size_t ray) const {
  if ((valid_ >> ray & 1) == 0) return HitState::kInvalid;
  return (best_.found >> ray & 1) != 0 ? HitState::kHit : HitState::kMiss;
}

std::uint32_t PacketCaster::work(std::size_t ray) const {
  if ((valid_ >> ray & 1) == 0) return 0;
  const std::uint32_t work =
      std::min(scene_.work[ray] + mesh_.work[ray], accel::geometry::kWorkDeferred - 1);
  const bool deferred = (saw_deferred_ >> ray & 1) != 0;
  return work | (deferred ? accel::geometry::kWorkDeferred : 0);
}

RayTally PacketCaster::count(std::size_t ray) {
  RayTally tally{.work = work(ray), .state = state(ray)};
  if (tally.state == HitState::kInvalid) tally.count = kInvalidCount;
  if (tally.state == HitState::kHit) tally.count = collected_[ray].count(stats_);
  return tally;
}

RayTally PacketCaster::list(std::size_t ray, std::vector<Hit>& hits) {
  RayTally tally{.work = work(ray), .state = state(ray)};
  if (tally.state != HitState::kHit) return tally;
  const accel::geometry::Ray given = (*rays_)[range_.first + ray];
  const std::span<const accel::mesh::ListedHit> found = collected_[ray].list(stats_, tally.cut_off);
  for (const accel::mesh::ListedHit& listed : found)
    hits.push_back(hit_of(listed, trees_, given, options_.surface));
  tally.count = static_cast<std::uint32_t>(found.size());
  return tally;
}

void PacketCaster::write(const HitColumns& hits) {
  for (std::size_t i = 0; i < kLanes; ++i) scene_.work[i] += mesh_.work[i];
  const accel::wide::Outcome outcome{best_,  scene_.work,   first_lanes(range_.count) & ~alone_,
                                     valid_, saw_deferred_, scene_.any};
  accel::wide::write(outcome, hits, range_.first);
  // Trees that this thread has left may be gone once its pin is renewed.
  if (options_.surface && !scene_.any)
    write_surfaces({given_, outcome, range_, !renewed_}, trees_, *rays_, hits);
}

TraceStats PacketCaster::stats() const {
  TraceStats stats = stats_;
  counters_.add_to(stats);
  return stats;
}

}  // namespace sightline::scenegraph::query
