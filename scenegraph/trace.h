// The way of a ray batch: snapshot, instances near to far, growing trees, hits.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/query/build_progress.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph {

/// Rays are cut into blocks of this many; a block is one task, and the grain of cancelling.
inline constexpr std::size_t kRaysPerBlock = 512;
/// A block whose hits are listed has at most kRaysPerListBlock rays, and so few (but one) that it
/// lists at most kHitsPerListBlock hits.
inline constexpr std::size_t kRaysPerListBlock = 64;
inline constexpr std::size_t kHitsPerListBlock = 16384;

/// Work done for one batch. Sums over threads; deterministic on one thread.
struct TraceStats {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;  ///< Rays with a hit, whatever the kind.
  std::uint64_t invalid = 0;
  std::uint64_t hits_found = 0;       ///< kCount: sum of the counts. kAll: hits listed.
  std::uint64_t cut_off = 0;          ///< kAll: rays with more than max_hits.
  std::uint64_t traversal_steps = 0;  ///< Inner nodes visited, scene level included.
  std::uint64_t triangle_tests = 0;   ///< Scans of unbuilt cells included.
  std::uint64_t instances_entered = 0;
  std::uint64_t cells_expanded = 0;
  std::uint64_t touches = 0;  ///< Reference bounds read by build passes.
  /// Of both, those for the dynamic tree and the meshes that were entered through it. (Where
  /// everything is built, those of the dynamic tree alone.)
  std::uint64_t dynamic_touches = 0;
  std::uint64_t touches_prepare = 0;  ///< Boxes made from vertices.
  double build_seconds = 0;           ///< Summed over threads.

  TraceStats& operator+=(const TraceStats& other);
};

/// What count_hits and list_hits say of a ray.
struct RayTally {
  std::uint32_t count = 0;  ///< Distinct hits, at most kMaxCount; of list_hits: those listed.
  std::uint32_t work = 0;   ///< As Hit::work.
  accel::geometry::HitState state = accel::geometry::HitState::kMiss;
  bool cut_off = false;  ///< There are farther hits than those listed.
};
inline constexpr std::uint32_t kInvalidCount = 0xffffffffu;  ///< count_hits: of an invalid ray.
inline constexpr std::uint32_t kMaxCount = kInvalidCount - 1;

/// Answers every ray of the batch at this one revision: hits[i] is the answer to rays[i].
/// kAny reports only `state` (and `work`). Runs in the calling thread's oneTBB arena, in parallel.
/// Errors: kCancelled (hits are then incomplete), kInvalidArgument (sizes disagree, or the kind is
/// not kClosest or kAny). A bad ray is marked HitState::kInvalid and never fails the batch.
Result<TraceStats> trace(const revision::Snapshot& snapshot,
                         std::span<const accel::geometry::Ray> rays,
                         std::span<accel::geometry::Hit> hits, const TraceOptions& options);

/// kCount: tallies[i] is the answer to rays[i]. Memory for a ray is in proportion to its hits in
/// one mesh, and freed with the block. Errors as of trace().
Result<TraceStats> count_hits(const revision::Snapshot& snapshot,
                              std::span<const accel::geometry::Ray> rays,
                              std::span<RayTally> tallies, const TraceOptions& options);

/// kAll: `hits` becomes the hits of the rays, in the order of the rays, those of rays[i]
/// (tallies[i].count of them) by (t, node, primitive). An invalid ray has none. Only the first
/// TraceStats::rays of the rays are answered: all, unless hits_at_once is reached before. Needs
/// memory for at most twice (hits_at_once + a block's hits for each thread). Errors as of trace().
Result<TraceStats> list_hits(const revision::Snapshot& snapshot,
                             std::span<const accel::geometry::Ray> rays,
                             std::span<RayTally> tallies, std::vector<accel::geometry::Hit>& hits,
                             const TraceOptions& options);

/// Builds every tree of the snapshot to its end ("expand everything"). `progress` is told mesh by
/// mesh and must be fresh. Errors: kCancelled.
Result<TraceStats> build_all(const revision::Snapshot& snapshot,
                             const std::atomic<bool>* cancelled = nullptr,
                             query::BuildProgress* progress = nullptr);

}  // namespace sightline::scenegraph
