// Answers a batch of rays at one revision. Start reading here.
//
// answer_in_blocks pins the snapshot's static and dynamic tree and, for each block of rays, an
// epoch. For each ray RayCaster then
//   1. orders the two trees by where the ray enters them  (trees_by_entry),
//   2. walks the instances of each, near to far           (walk_instances),
//   3. enters an instance's frame and asks its mesh       (enter_instance),
//   4. returns the hit, the count or the list             (cast, count, list).
// Steps 2 and 3 expand unbuilt cells on the way, as TraceOptions::growth allows.
#include "scenegraph/trace.h"

#include <algorithm>
#include <atomic>
#include <string>

#include "scenegraph/query/ray_blocks.h"
#include "scenegraph/query/ray_caster.h"

namespace sightline::scenegraph {
namespace {

Status check_sizes(std::size_t rays, std::size_t answers) {
  if (rays == answers) return {};
  return Error{Code::kInvalidArgument,
               std::to_string(rays) + " rays but room for " + std::to_string(answers) + " answers",
               "COUNT_MISMATCH"};
}

}  // namespace

Result<TraceStats> trace(const revision::Snapshot& snapshot,
                         std::span<const accel::geometry::Ray> rays,
                         std::span<accel::geometry::Hit> hits, const TraceOptions& options) {
  if (const Status good = check_sizes(rays.size(), hits.size()); !good) return good.error();
  if (options.kind != QueryKind::kClosest && options.kind != QueryKind::kAny)
    return Error{Code::kInvalidArgument, "trace() answers closest and any", "UNKNOWN_KIND"};
  const auto answer = [&](query::RayCaster& caster, const query::RayBlock& block) {
    answer_block(caster, block, [&](std::size_t i, accel::lazy::WhenPending when_pending) {
      return caster.cast(rays[i], when_pending, hits[i]);
    });
  };
  return query::answer_in_blocks(snapshot, rays.size(), kRaysPerBlock, options, answer);
}

Result<TraceStats> count_hits(const revision::Snapshot& snapshot,
                              std::span<const accel::geometry::Ray> rays,
                              std::span<RayTally> tallies, const TraceOptions& options) {
  if (const Status good = check_sizes(rays.size(), tallies.size()); !good) return good.error();
  const auto answer = [&](query::RayCaster& caster, const query::RayBlock& block) {
    answer_block(caster, block, [&](std::size_t i, accel::lazy::WhenPending when_pending) {
      const std::optional<RayTally> tally = caster.count(rays[i], when_pending);
      if (tally) tallies[i] = *tally;
      return tally.has_value();
    });
  };
  return query::answer_in_blocks(snapshot, rays.size(), kRaysPerBlock, options, answer);
}

Result<TraceStats> list_hits(const revision::Snapshot& snapshot,
                             std::span<const accel::geometry::Ray> rays,
                             std::span<RayTally> tallies, std::vector<accel::geometry::Hit>& hits,
                             const TraceOptions& options) {
  if (const Status good = check_sizes(rays.size(), tallies.size()); !good) return good.error();
  const std::size_t rays_per_block = std::clamp<std::size_t>(
      kHitsPerListBlock / std::max(options.max_hits, 1u), 1, kRaysPerListBlock);
  std::vector<std::vector<accel::geometry::Hit>> of_blocks((rays.size() + rays_per_block - 1) /
                                                           rays_per_block);
  // Blocks are taken in order, so that the answered rays are always the first ones.
  std::atomic<std::size_t> next{0}, listed{0};
  auto traced = query::answer_in_blocks(
      snapshot, rays.size(), rays_per_block, options,
      [&](query::RayCaster& caster, const query::RayBlock&) {
        if (listed.load(std::memory_order_relaxed) >= options.hits_at_once) return;
        const std::size_t block = next.fetch_add(1, std::memory_order_relaxed);
        const std::size_t first = block * rays_per_block;
        for (std::size_t i = first; i < std::min(first + rays_per_block, rays.size()); ++i)
          tallies[i] = caster.list(rays[i], of_blocks[block]);
        listed.fetch_add(of_blocks[block].size(), std::memory_order_relaxed);
      });
  if (!traced) return traced;
  hits.clear();
  hits.reserve(traced->hits_found);
  for (std::vector<accel::geometry::Hit>& block : of_blocks) {
    hits.insert(hits.end(), block.begin(), block.end());
    block = {};
  }
  return traced;
}

}  // namespace sightline::scenegraph
