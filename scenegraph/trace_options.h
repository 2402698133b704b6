// What a batch of rays asks for, what it cost, and what is reported for each counted or listed ray.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "accel/geometry/facing.h"
#include "accel/geometry/ray.h"
#include "accel/lazy/growth.h"

namespace sightline::scenegraph {

namespace query {
class Selection;
struct BuildProgress;
}  // namespace query

/// All kinds see the same hits, so that any == (count > 0) == (closest is a hit) == (all is not
/// empty), with any limits, masks, culling and selection.
enum class QueryKind : std::uint8_t {
  kClosest,  ///< The hit with the smallest (t, node, primitive).
  kAny,      ///< Whether there is a hit.
  kCount,    ///< The number of distinct (node, primitive) that are hit.
  kAll,      ///< Every hit by (t, node, primitive), each (node, primitive) once.
};

using accel::lazy::Growth;

struct TraceOptions {
  QueryKind kind = QueryKind::kClosest;  ///< For trace(): kClosest or kAny.
  Growth growth = Growth::kFirstTouch;
  /// Whether barycentrics and normals are computed.
  bool surface = true;
  /// Whether the rays are points: their origins, to which the nearest faces are wanted. `tmax` is
  /// the largest distance, and `t` of a hit is the distance in the scene (docs/distance_rule.md);
  /// directions must be valid, and do not matter. There is no culling.
  bool points = false;
  /// Which hits are ignored, by the winding in the mesh's own frame, like normals: a mirrored
  /// instance keeps its outside. Culled hits do not exist for any kind.
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  /// For count_hits(): whether hits count that are beyond the origin exactly (geometry::is_ahead),
  /// however near, in place of a tmin, which is 0.
  bool from_origin = false;
  /// The nodes that rays see, from the traced snapshot; null: all. Must outlive the batch.
  const query::Selection* selection = nullptr;
  /// For list_hits(): the number of nearest hits kept for each ray.
  std::uint32_t max_hits = 256;
  /// For list_hits(): no block begins after this many hits are listed.
  std::size_t hits_at_once = std::numeric_limits<std::size_t>::max();
  /// For list_hits(): most hits of a block, unless a single ray has more.
  std::size_t hits_per_block = 16384;
  /// Checked before every ray, and within long searches and builds. Once true, no further ray is
  /// cast, and the batch ends with kCancelled.
  const std::atomic<bool>* cancelled = nullptr;
  /// A batch that is cancelled ends without an error, and the rays without an answer are marked
  /// (HitState::kUnanswered). What was built for them remains: asking again continues from there.
  bool partial = false;
  /// For Growth::kFull: receives the progress of the build. Must outlive the batch.
  query::BuildProgress* progress = nullptr;
};

inline bool is_cancelled(const std::atomic<bool>* cancelled) {
  return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
}

/// Rays of one block. A block is one task.
inline constexpr std::size_t kRaysPerBlock = 512;
/// Most rays of one block that lists hits.
inline constexpr std::size_t kRaysPerListBlock = 64;

/// Work done for one batch, summed over threads. Deterministic on one thread.
struct TraceStats {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;  ///< Rays with a hit, of any kind.
  std::uint64_t invalid = 0;
  std::uint64_t unanswered = 0;       ///< Rays without an answer, not among `rays`.
  std::uint64_t hits_found = 0;       ///< kCount: sum of the counts. kAll: hits listed.
  std::uint64_t cut_off = 0;          ///< kAll: rays with more than max_hits.
  std::uint64_t traversal_steps = 0;  ///< Inner nodes visited, scene level included.
  std::uint64_t triangle_tests = 0;   ///< Triangles tested, searches of deferred cells included.
  std::uint64_t instances_entered = 0;
  std::uint64_t cells_expanded = 0;
  std::uint64_t trees_begun = 0;  ///< Trees whose roots were expanded.
  std::uint64_t touches = 0;      ///< Reference bounds read by build passes.
  /// The part of `touches` and `touches_prepare` for the dynamic trees and the meshes that rays
  /// entered through them. (A full build counts only the dynamic trees.)
  std::uint64_t dynamic_touches = 0;
  std::uint64_t touches_prepare = 0;  ///< Boxes made from vertices.
  double build_seconds = 0;           ///< Time spent on building, summed over threads.

  TraceStats& operator+=(const TraceStats& o) {
    rays += o.rays;
    hits += o.hits;
    invalid += o.invalid;
    unanswered += o.unanswered;
    hits_found += o.hits_found;
    cut_off += o.cut_off;
    traversal_steps += o.traversal_steps;
    triangle_tests += o.triangle_tests;
    instances_entered += o.instances_entered;
    cells_expanded += o.cells_expanded;
    trees_begun += o.trees_begun;
    touches += o.touches;
    dynamic_touches += o.dynamic_touches;
    touches_prepare += o.touches_prepare;
    build_seconds += o.build_seconds;
    return *this;
  }
};

/// The answer of count_hits and list_hits to one ray.
struct RayTally {
  std::uint32_t count = 0;  ///< Distinct hits, at most kMaxCount. For list_hits: those listed.
  std::uint32_t work = 0;   ///< See Hit::work.
  accel::geometry::HitState state = accel::geometry::HitState::kMiss;
  bool cut_off = false;  ///< Whether there are farther hits than those listed.
};
inline constexpr std::uint32_t kInvalidCount = 0xffffffffu;  ///< Count of an invalid ray.
/// Count of an unanswered ray.
inline constexpr std::uint32_t kUnansweredCount = kInvalidCount - 1;
inline constexpr std::uint32_t kMaxCount = kUnansweredCount - 1;

}  // namespace sightline::scenegraph
