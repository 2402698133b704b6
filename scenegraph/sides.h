// On which side of a scene's surfaces points are.
#pragma once

#include <cstdint>
#include <span>

#include "accel/geometry/ray_columns.h"
#include "proto/result.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/side_rule.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph {

/// The answers, one for each point.
struct SideAnswers {
  std::span<Side> sides;
  /// Of the rays, those that say inside; 0 for points without an answer. Empty: not asked for.
  std::span<std::uint8_t> votes{};
  /// kParity and kWinding: the crossings of each ray, those of a point in a row; 0 for points
  /// without an answer. Empty: not asked for.
  std::span<std::uint32_t> crossings{};
};

/// Answers every point, at this one revision. Points are the origins of `points`, with their masks;
/// directions and limits do not matter. Of the options, kind, points, surface and culling do not
/// matter. Runs in the calling thread's oneTBB arena, in parallel. Errors: those of trace(), and
/// kInvalidArgument for another number of rays, or room for another number of answers. Of the
/// stats, `rays`, `invalid` and `unanswered` count points, and no hits are counted.
Result<TraceStats> find_sides(const revision::Snapshot& snapshot,
                              const accel::geometry::RayColumns& points,
                              const SideQuestion& question, const SideAnswers& answers,
                              const TraceOptions& options);

}  // namespace sightline::scenegraph
