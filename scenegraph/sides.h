// On which side of a scene's surfaces points are.
#pragma once

#include <cstdint>
#include <span>

#include "accel/geometry/ray_columns.h"
#include "proto/result.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph {

/// What decides (docs/distance_rule.md, section 9).
enum class SideRule : std::uint8_t {
  kParity,   ///< Inside: a ray from the point crosses an odd number of faces.
  kWinding,  ///< Inside: the ray does not meet as many faces from behind as from the front.
  kNormal,   ///< Inside: behind the nearest face, or the faces that share the nearest edge or
             ///< corner.
};

enum class Side : std::uint8_t { kOutside = 0, kInside = 1, kInvalid = 2, kUnanswered = 4 };

inline constexpr std::uint32_t kMaxSideRays = 63;

struct SideQuestion {
  SideRule rule = SideRule::kParity;
  /// kParity and kWinding: the number of rays whose majority decides: odd, at most kMaxSideRays.
  std::uint32_t rays = 1;
};

/// The answers, one for each point.
struct SideAnswers {
  std::span<Side> sides;
  /// Of the rays, those that say inside; 0 for points without an answer. Empty: not asked for.
  std::span<std::uint8_t> votes;
};

/// Answers every point, at this one revision. Points are the origins of `points`, with their masks;
/// directions and limits do not matter. Of the options, kind, points, surface and culling do not
/// matter. Runs in the calling thread's oneTBB arena, in parallel. Errors: those of trace(), and
/// kInvalidArgument for another number of rays. Of the stats, `rays`, `invalid` and `unanswered`
/// count points, and no hits are counted.
Result<TraceStats> find_sides(const revision::Snapshot& snapshot,
                              const accel::geometry::RayColumns& points,
                              const SideQuestion& question, const SideAnswers& answers,
                              const TraceOptions& options);

}  // namespace sightline::scenegraph
