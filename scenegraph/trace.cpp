// The way of a batch of rays through one revision. Start reading here.
//
//   trace_blocks   pins the trees of the revision, and cuts the rays into blocks
//   cast_rays      pins an epoch for each block, and takes its packets through the trees, their
//                  instances and the meshes of those (query/caster.h)
//   trace, count_hits, list_hits   return the hits, their number or all of them
//
// Deferred cells on the way are expanded, searched or skipped as TraceOptions::growth says: see
// accel/lazy/growing_leaf.h.
#include "scenegraph/trace.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <string>
#include <utility>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/last_use.h"
#include "scenegraph/query/cast_counters.h"
#include "scenegraph/query/caster.h"
#include "scenegraph/query/point_order.h"
#include "scenegraph/query/ray_blocks.h"
#include "scenegraph/query/sample_rays.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitColumns;
using accel::geometry::Ray;
using accel::geometry::RayColumns;
using accel::kdtree::EpochPin;
using accel::wide::kLanes;
using query::Caster;
using query::RayBlock;
using query::RayPacket;

/// Runs answer(OpenTrees, RayBlock), which returns its TraceStats, for every block of a batch.
template <class Answer>
Result<TraceStats> trace_blocks(const revision::Snapshot& snapshot, QueryKind kind,
                                const RayColumns& rays, std::size_t rays_per_block,
                                const TraceOptions& options, const Answer& answer) {
  accel::kdtree::begin_batch();
  Result<TraceStats> built = options.growth == Growth::kFull
                                 ? build_all(snapshot, options.cancelled, options.progress)
                                 : TraceStats{};
  if (!built && options.partial && built.error().code == Code::kCancelled) return TraceStats{};
  if (!built) return built;
  const instances::OpenTrees trees = snapshot.trees();
  const auto answer_all = [&] {
    // Points pay cell by cell.
    if (options.growth == Growth::kDemand && !options.points)
      *built += query::grow_for_batch(trees, rays, kind, options);
    return query::run_blocks(rays.size, rays_per_block, options,
                             [&](const RayBlock& block) { return answer(trees, block); });
  };
  Result<TraceStats> traced = query::or_error(answer_all);
  if (traced) *traced += *built;
  return traced;
}

/// Calls use(Caster) with a caster of a block of rays, and returns its stats.
template <class Use>
TraceStats with_caster(const instances::OpenTrees& trees, QueryKind kind,
                       const TraceOptions& options, const Use& use) {
  TraceStats stats;
  std::uint64_t entries = 0;
  {
    EpochPin pin;
    Caster caster(pin, trees, kind, options);
    use(caster);
    stats = caster.stats();
    entries = caster.static_entries();
  }
  if (!accel::lazy::may_grow(options.growth)) return stats;
  accel::kdtree::BuildCounters built;
  trees.static_tree().count_entries(entries, built, options.cancelled);
  query::add(built, stats);
  return stats;
}

/// Casts every ray. Calls keep(Caster, first, lanes) where the caster has the answers to some rays
/// from `first` on, which have a bit in `lanes`.
template <class Keep>
Result<TraceStats> cast_rays(const revision::Snapshot& snapshot, QueryKind kind,
                             const RayColumns& rays, const TraceOptions& options,
                             const Keep& keep) {
  const auto answer_block = [&](Caster& caster, const RayBlock& block) {
    const auto cast = [&](const RayPacket& packet, bool waits) {
      const std::uint32_t answered = caster.cast(rays, packet, waits);
      if (answered != 0) keep(caster, packet.first, answered);
      return packet.lanes & ~answered;
    };
    std::vector<RayPacket> postponed;
    for (std::size_t i = block.first; i < block.end && !is_cancelled(options.cancelled);
         i += kLanes) {
      RayPacket packet{i, std::min(kLanes, block.end - i)};
      packet.lanes = cast(packet, /*waits=*/false);
      if (packet.lanes != 0) postponed.push_back(packet);
    }
    query::answer_postponed(postponed, caster, options.cancelled, cast);
  };
  const auto answer = [&](const instances::OpenTrees& trees, const RayBlock& block) {
    return with_caster(trees, kind, options, [&](Caster& caster) { answer_block(caster, block); });
  };
  return trace_blocks(snapshot, kind, rays, kRaysPerBlock, options, answer);
}

/// Appends the hits of the rays of a block, in order.
void list_block(Caster& caster, const RayColumns& rays, const RayBlock& block,
                std::span<RayTally> tallies, std::vector<Hit>& hits, const TraceOptions& options) {
  for (std::size_t i = block.first; i < block.end; i += kLanes) {
    if (is_cancelled(options.cancelled)) break;
    const RayPacket packet{i, std::min(kLanes, block.end - i)};
    const std::uint32_t answered = caster.cast(rays, packet, /*waits=*/true);
    for (std::uint32_t left = answered; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      tallies[i + lane] = caster.list(lane, hits);
    }
  }
}

/// The stats of a batch, with the rays that have no answer.
Result<TraceStats> with_unanswered(Result<TraceStats> traced, std::size_t rays,
                                   const TraceOptions& options) {
  if (traced && options.partial && is_cancelled(options.cancelled))
    traced->unanswered = rays - traced->rays;
  return traced;
}

void mark_unanswered(const HitColumns& hits) {
  Hit unanswered;
  unanswered.t = -accel::geometry::kInfinity;
  unanswered.state = accel::geometry::HitState::kUnanswered;
  for (std::size_t i = 0; i < hits.size; ++i) hits.set(i, unanswered);
}

void mark_unanswered(std::span<RayTally> tallies, std::uint32_t count) {
  std::fill(tallies.begin(), tallies.end(),
            RayTally{.count = count, .state = accel::geometry::HitState::kUnanswered});
}

Status check_sizes(std::size_t rays, std::size_t answers) {
  if (rays == answers) return {};
  return Error{Code::kInvalidArgument,
               std::to_string(rays) + " rays but room for " + std::to_string(answers) + " answers",
               "COUNT_MISMATCH"};
}

/// Traces rays packet by packet, as they come.
Result<TraceStats> trace_in_order(const revision::Snapshot& snapshot, const RayColumns& rays,
                                  const HitColumns& hits, const TraceOptions& options) {
  // Packets set only their own bits.
  if (hits.bits != nullptr) std::fill_n(hits.bits, (hits.size + 7) / 8, std::uint8_t{0});
  if (options.partial) mark_unanswered(hits);
  auto traced = cast_rays(snapshot, options.kind, rays, options,
                          [&](Caster& caster, std::size_t, std::uint32_t) { caster.write(hits); });
  return with_unanswered(std::move(traced), rays.size, options);
}

/// Answers points in the order of OrderedPoints.
Result<TraceStats> trace_points(const revision::Snapshot& snapshot, const RayColumns& points,
                                const HitColumns& hits, const TraceOptions& options) {
  return query::or_error([&]() -> Result<TraceStats> {
    const query::OrderedPoints ordered(points);
    std::vector<Hit> found(points.size);
    auto traced = trace_in_order(snapshot, ordered.columns, columns_of(std::span(found)), options);
    if (!traced) return traced;
    for (std::size_t i = 0; i < found.size(); ++i) hits.set(ordered.order[i], found[i]);
    return traced;
  });
}

}  // namespace

Result<TraceStats> trace(const revision::Snapshot& snapshot, const RayColumns& rays,
                         const HitColumns& hits, const TraceOptions& given_options) {
  TraceOptions options = given_options;
  options.surface &= hits.has_surface();
  if (const Status good = check_sizes(rays.size, hits.size); !good) return good.error();
  if (options.kind != QueryKind::kClosest && options.kind != QueryKind::kAny)
    return Error{Code::kInvalidArgument, "trace() answers closest and any", "UNKNOWN_KIND"};
  if (options.points && rays.size > 1) return trace_points(snapshot, rays, hits, options);
  return trace_in_order(snapshot, rays, hits, options);
}

Result<TraceStats> trace(const revision::Snapshot& snapshot, std::span<const Ray> rays,
                         std::span<Hit> hits, const TraceOptions& options) {
  return trace(snapshot, columns_of(rays), columns_of(hits), options);
}

Result<TraceStats> count_hits(const revision::Snapshot& snapshot, const RayColumns& rays,
                              std::span<RayTally> tallies, const TraceOptions& options) {
  if (const Status good = check_sizes(rays.size, tallies.size()); !good) return good.error();
  if (options.partial) mark_unanswered(tallies, kUnansweredCount);
  auto traced = cast_rays(snapshot, QueryKind::kCount, rays, options,
                          [&](Caster& caster, std::size_t first, std::uint32_t lanes) {
                            for (; lanes != 0; lanes &= lanes - 1) {
                              const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
                              tallies[first + lane] = caster.count(lane);
                            }
                          });
  return with_unanswered(std::move(traced), rays.size, options);
}

Result<TraceStats> count_hits(const revision::Snapshot& snapshot, std::span<const Ray> rays,
                              std::span<RayTally> tallies, const TraceOptions& options) {
  return count_hits(snapshot, columns_of(rays), tallies, options);
}

Result<TraceStats> list_hits(const revision::Snapshot& snapshot, std::span<const Ray> rays,
                             std::span<RayTally> tallies, std::vector<Hit>& hits,
                             const TraceOptions& options) {
  if (const Status good = check_sizes(rays.size(), tallies.size()); !good) return good.error();
  const std::size_t rays_per_block = std::clamp<std::size_t>(
      options.hits_per_block / std::max(options.max_hits, 1u), 1, kRaysPerListBlock);
  std::vector<std::vector<Hit>> of_blocks((rays.size() + rays_per_block - 1) / rays_per_block);
  // Blocks are taken in order, so that the answered rays are always the first ones.
  std::atomic<std::size_t> next{0}, listed{0};
  const RayColumns columns = columns_of(rays);
  if (options.partial) mark_unanswered(tallies, 0);
  const auto answer = [&](const instances::OpenTrees& trees, const RayBlock&) -> TraceStats {
    if (listed.load(std::memory_order_relaxed) >= options.hits_at_once) return {};
    const std::size_t block = next.fetch_add(1, std::memory_order_relaxed);
    const std::size_t first = block * rays_per_block;
    const RayBlock part{first, std::min(first + rays_per_block, rays.size())};
    const TraceStats stats = with_caster(trees, QueryKind::kAll, options, [&](Caster& caster) {
      list_block(caster, columns, part, tallies, of_blocks[block], options);
    });
    listed.fetch_add(of_blocks[block].size(), std::memory_order_relaxed);
    return stats;
  };
  Result<TraceStats> traced =
      trace_blocks(snapshot, QueryKind::kCount, columns, rays_per_block, options, answer);
  if (!traced) return traced;
  hits.clear();
  hits.reserve(traced->hits_found);
  for (std::vector<Hit>& block : of_blocks) {
    hits.insert(hits.end(), block.begin(), block.end());
    block = {};
  }
  return with_unanswered(std::move(traced), rays.size(), options);
}

Status grow_for_rays(const revision::Snapshot& snapshot, std::span<const Ray> rays,
                     const TraceOptions& options, query::BuildProgress& progress) {
  // Listing hits grows the same cells as counting them.
  const QueryKind kind = options.kind == QueryKind::kAll ? QueryKind::kCount : options.kind;
  constexpr std::size_t kRaysPerReport = 4096;
  while (!rays.empty()) {
    const auto part = rays.first(std::min(rays.size(), kRaysPerReport));
    rays = rays.subspan(part.size());
    const auto cast = cast_rays(snapshot, kind, columns_of(part), options,
                                [](Caster&, std::size_t, std::uint32_t) {});
    if (!cast) return cast.error();
    progress.add(cast->cells_expanded, cast->build_seconds);
    progress.rays_done += part.size();
  }
  return {};
}

}  // namespace sightline::scenegraph
