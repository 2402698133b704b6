// Answers a batch of rays at one revision. Start reading in trace.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/hit_columns.h"
#include "accel/geometry/ray.h"
#include "accel/geometry/ray_columns.h"
#include "proto/result.h"
#include "scenegraph/query/build.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph {

using query::build_all;

/// Answers every ray of the batch at this one revision: hits[i] is the answer to rays[i].
/// kAny reports only `state` (and `work`). Runs in the calling thread's oneTBB arena, in parallel.
/// Errors: kCancelled and kResourceExhausted (no memory to build what the rays need; hits are then
/// incomplete), kInvalidArgument (sizes disagree, or the kind is not kClosest or kAny). A bad ray
/// is marked HitState::kInvalid and never fails the batch.
Result<TraceStats> trace(const revision::Snapshot& snapshot,
                         std::span<const accel::geometry::Ray> rays,
                         std::span<accel::geometry::Hit> hits, const TraceOptions& options);

/// Answers rays that are read where they lie, and writes the fields of hits that are asked for;
/// otherwise as trace() of arrays. `surface` of the options counts only if weights or normals are
/// asked. Fields of kAny that only a closest hit has are those of a miss. The numbers of the rays
/// must not overlap the fields.
Result<TraceStats> trace(const revision::Snapshot& snapshot,
                         const accel::geometry::RayColumns& rays,
                         const accel::geometry::HitColumns& hits, const TraceOptions& options);

/// kCount: tallies[i] is the answer to rays[i]. The memory for a ray is in proportion to its hits
/// in one mesh, and freed with the block. Errors are those of trace().
Result<TraceStats> count_hits(const revision::Snapshot& snapshot,
                              std::span<const accel::geometry::Ray> rays,
                              std::span<RayTally> tallies, const TraceOptions& options);
Result<TraceStats> count_hits(const revision::Snapshot& snapshot,
                              const accel::geometry::RayColumns& rays, std::span<RayTally> tallies,
                              const TraceOptions& options);

/// kAll: `hits` becomes the hits of the rays, in the order of the rays; those of rays[i]
/// (tallies[i].count of them) are sorted by (t, node, primitive). An invalid ray has none. Answers
/// only the first TraceStats::rays of the rays: all, unless hits_at_once is reached before. Needs
/// memory for at most twice (hits_at_once + a block's hits for each thread). Errors are those of
/// trace().
Result<TraceStats> list_hits(const revision::Snapshot& snapshot,
                             std::span<const accel::geometry::Ray> rays,
                             std::span<RayTally> tallies, std::vector<accel::geometry::Hit>& hits,
                             const TraceOptions& options);

/// Grows what a cast of these rays would grow, and keeps no hit. `options` are those of the cast,
/// of any kind. Parallel in the caller's arena. Errors: kCancelled,
/// kResourceExhausted.
Status grow_for_rays(const revision::Snapshot& snapshot, std::span<const accel::geometry::Ray> rays,
                     const TraceOptions& options, query::BuildProgress& progress);

}  // namespace sightline::scenegraph
