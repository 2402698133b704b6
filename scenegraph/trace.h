// The way of a ray batch: snapshot, instances near to far, growing trees, hits.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/snapshot.h"

namespace sightline::scenegraph {

enum class QueryKind : std::uint8_t { kClosest, kAny };

/// How much tree a batch may grow.
enum class Growth : std::uint8_t {
  kFirstTouch,  ///< A cell is expanded by the first ray that enters it.
  kFull,        ///< Everything is built before the first ray.
  kNone,        ///< Nothing is grown; what is not built is searched triangle by triangle.
  kBuiltOnly,   ///< Nothing is grown and what is not built is passed over: shows what exists,
                ///< answers no query.
};

/// Rays are cut into blocks of this many; a block is one task, and the grain of cancelling.
inline constexpr std::size_t kRaysPerBlock = 512;

struct TraceOptions {
  QueryKind kind = QueryKind::kClosest;
  Growth growth = Growth::kFirstTouch;
  /// Barycentrics and normals are computed only if asked for.
  bool surface = true;
  /// Checked before every block; once true, no further block is begun.
  const std::atomic<bool>* cancelled = nullptr;
};

/// Work done for one batch. Sums over threads; deterministic on one thread.
struct TraceStats {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;
  std::uint64_t invalid = 0;
  std::uint64_t traversal_steps = 0;  ///< Inner nodes visited, scene level included.
  std::uint64_t triangle_tests = 0;   ///< Scans of unbuilt cells included.
  std::uint64_t instances_entered = 0;
  std::uint64_t cells_expanded = 0;
  std::uint64_t touches = 0;          ///< Reference bounds read by build passes.
  std::uint64_t touches_prepare = 0;  ///< Boxes made from vertices.
  double build_seconds = 0;           ///< Summed over threads.

  TraceStats& operator+=(const TraceStats& other);
};

/// Answers every ray of the batch at this one revision: hits[i] is the answer to rays[i].
/// kAny reports only `state` (and `work`). Runs in the calling thread's oneTBB arena, in parallel.
/// Errors: kCancelled (hits are then incomplete), kInvalidArgument (sizes disagree).
/// A bad ray is marked HitState::kInvalid and never fails the batch.
Result<TraceStats> trace(const Snapshot& snapshot, std::span<const accel::Ray> rays,
                         std::span<accel::Hit> hits, const TraceOptions& options);

/// Builds every tree of the snapshot to its end ("expand everything"). Errors: kCancelled.
Result<TraceStats> build_all(const Snapshot& snapshot,
                             const std::atomic<bool>* cancelled = nullptr);

}  // namespace sightline::scenegraph
