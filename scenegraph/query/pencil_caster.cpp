#include "scenegraph/query/pencil_caster.h"

#include <algorithm>
#include <bit>

#include "accel/mesh/mesh_tree.h"
#include "scenegraph/query/on_deferred.h"
#include "scenegraph/query/packet_hits.h"
#include "scenegraph/query/selection.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::wide::kLanes;
using accel::wide::Packet;

/// The instance of a revision that has one alone, and shows it to rays.
const instances::Instance* find_only(const instances::OpenTrees& trees,
                                     const TraceOptions& options) {
  if (trees.size() != 1) return nullptr;
  const bool is_static = trees.static_tree.size() == 1;
  const instances::Instances& tree = is_static ? trees.static_tree : trees.dynamic_tree;
  const accel::kdtree::Slot root = accel::kdtree::load(tree.tree().root());
  if (!root.is_leaf() || root.leaf_count() != 1) return nullptr;
  if (is_static && trees.removed != nullptr && trees.removed->has(0)) return nullptr;
  if (options.selection != nullptr && !options.selection->selects(0)) return nullptr;
  return &tree[root.leaf_first()];
}

/// The rays that see an instance.
std::uint32_t seeing(std::span<const Ray> rays, std::uint32_t mask) {
  std::uint32_t common = mask;
  for (const Ray& ray : rays) common &= ray.mask;
  if (common != 0) return static_cast<std::uint32_t>((std::uint64_t{1} << rays.size()) - 1);
  std::uint32_t lanes = 0;
  for (std::size_t i = 0; i < rays.size(); ++i)
    lanes |= static_cast<std::uint32_t>((rays[i].mask & mask) != 0) << i;
  return lanes;
}

}  // namespace

PencilCaster::PencilCaster(const instances::OpenTrees& trees, const TraceOptions& options)
    : trees_(trees), options_(options), only_(find_only(trees, options)) {
  if (only_ == nullptr) return;
  for (std::size_t p = 0; p < packets_.size(); ++p) {
    Packet& packet = packets_[p];
    packet.best = &best_[p];
    packet.any = options.kind == QueryKind::kAny;
    packet.node = only_->node;
    packet.instance = 0;
    packet.culling = only_->mirrored ? turned(options.culling) : options.culling;
  }
}

std::uint32_t PencilCaster::cast(std::span<const Ray> rays, std::span<Hit> hits) {
  if (only_ == nullptr) return 0;
  if (to_skip_ > 0) {
    --to_skip_;
    return 0;
  }
  pin_.renew();
  const std::size_t packets = (rays.size() + kLanes - 1) / kLanes;
  const Lanes lanes = read(rays);
  accel::kdtree::WalkCounters walked;
  const Lanes done = only_->mesh->owned_tree().tree.query_pencil(std::span(packets_).first(packets),
                                                                 lanes, walked);
  const std::uint32_t answered = write(rays, hits, done);
  to_skip_ = failed_;
  failed_ = answered == 0 ? 2 * failed_ + 2 : 0;
  if (answered == 0) return 0;
  stats_.traversal_steps += walked.steps;
  stats_.triangle_tests += walked.tests;
  if (on_deferred(options_.growth) != accel::lazy::OnDeferred::kSkip &&
      !only_->entered->load(std::memory_order_relaxed))
    only_->entered->store(true, std::memory_order_relaxed);
  return answered;
}

/// Returns the rays in the instance's frame that are valid and see it.
PencilCaster::Lanes PencilCaster::read(std::span<const Ray> rays) {
  Lanes lanes{};
  for (std::size_t first = 0, p = 0; first < rays.size(); first += kLanes, ++p) {
    const std::span<const Ray> part = rays.subspan(first, std::min(kLanes, rays.size() - first));
    accel::wide::GivenRays& given = given_[p];
    Packet& packet = packets_[p];
    accel::wide::read(part, given);
    packet.work.fill(0);
    best_[p].clear();
    const std::uint32_t valid =
        accel::wide::valid(given, trees_.static_tree.center(), seeing(part, only_->mask));
    lanes[p] = accel::wide::carry(given, only_->local_from_world.m, valid, packet.rays);
  }
  return lanes;
}

std::uint32_t PencilCaster::write(std::span<const Ray> rays, std::span<Hit> hits,
                                  const Lanes& done) {
  std::uint32_t answered = 0;
  for (std::size_t first = 0, p = 0; first < rays.size(); first += kLanes, ++p) {
    const std::size_t count = std::min(kLanes, rays.size() - first);
    const std::uint32_t lanes = done[p];
    if (lanes != (std::uint64_t{1} << count) - 1) continue;
    answered |= 1u << p;
    const PacketHits packet{given_[p], best_[p], packets_[p].work, lanes,
                            lanes,     0,        packets_[p].any};
    write_hits(packet, hits.subspan(first, count));
    if (options_.surface && !packet.any)
      write_surfaces(packet, trees_, true, rays.subspan(first, count), hits.subspan(first, count));
    stats_.rays += count;
    stats_.hits += static_cast<std::uint64_t>(std::popcount(best_[p].found));
    stats_.instances_entered += count;
  }
  return answered;
}

}  // namespace sightline::scenegraph::query
