// What a batch of rays cost, and what is reported for each counted or listed ray.
#pragma once

#include <cstdint>

#include "accel/geometry/ray.h"

namespace sightline::scenegraph::query {

/// Work done for one batch, summed over threads. Deterministic on one thread.
struct TraceStats {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;  ///< Rays with a hit, of any kind.
  std::uint64_t invalid = 0;
  std::uint64_t hits_found = 0;       ///< kCount: sum of the counts. kAll: hits listed.
  std::uint64_t cut_off = 0;          ///< kAll: rays with more than max_hits.
  std::uint64_t traversal_steps = 0;  ///< Inner nodes visited, scene level included.
  std::uint64_t triangle_tests = 0;   ///< Scans of deferred cells included.
  std::uint64_t instances_entered = 0;
  std::uint64_t cells_expanded = 0;
  std::uint64_t touches = 0;  ///< Reference bounds read by build passes.
  /// The part of `touches` and `touches_prepare` for the dynamic tree and the meshes that rays
  /// entered through it. (For a full build: of the dynamic tree only.)
  std::uint64_t dynamic_touches = 0;
  std::uint64_t touches_prepare = 0;  ///< Boxes made from vertices.
  double build_seconds = 0;           ///< Summed over threads.

  TraceStats& operator+=(const TraceStats& other);
};

/// The answer of count_hits and list_hits to one ray.
struct RayTally {
  std::uint32_t count = 0;  ///< Distinct hits, at most kMaxCount. For list_hits: those listed.
  std::uint32_t work = 0;   ///< As Hit::work.
  accel::geometry::HitState state = accel::geometry::HitState::kMiss;
  bool cut_off = false;  ///< There are farther hits than those listed.
};
inline constexpr std::uint32_t kInvalidCount = 0xffffffffu;  ///< count_hits: for an invalid ray.
inline constexpr std::uint32_t kMaxCount = kInvalidCount - 1;

}  // namespace sightline::scenegraph::query
