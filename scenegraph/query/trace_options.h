// What a batch of rays asks for.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "accel/geometry/facing.h"

namespace sightline::scenegraph::query {

class Selection;
struct BuildProgress;

/// All kinds see the same hits, so that any == (count > 0) == (closest is a hit) == (all is not
/// empty), with any limits, masks, culling and selection.
enum class QueryKind : std::uint8_t {
  kClosest,  ///< The hit with the smallest (t, node, primitive).
  kAny,      ///< Whether there is a hit.
  kCount,    ///< The number of distinct (node, primitive) that are hit.
  kAll,      ///< Every hit by (t, node, primitive), each (node, primitive) once.
};

/// How much tree a batch may grow.
enum class Growth : std::uint8_t {
  kFirstTouch,  ///< The first ray that enters a cell expands it.
  kFull,        ///< Everything is built before the first ray.
  kNone,        ///< Nothing is grown; deferred cells are searched triangle by triangle.
  kBuiltOnly,   ///< Nothing is grown and deferred cells are skipped. Shows what exists; not an
                ///< answer to a query.
};

struct TraceOptions {
  QueryKind kind = QueryKind::kClosest;  ///< For trace(): kClosest or kAny.
  Growth growth = Growth::kFirstTouch;
  /// Whether barycentrics and normals are computed.
  bool surface = true;
  /// By the winding in scene coordinates, like normals: a mirrored instance reverses its mesh's
  /// windings. Culled hits do not exist for any kind.
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  /// The nodes that rays see, from the traced snapshot; null: all. Must outlive the batch.
  const Selection* selection = nullptr;
  /// For list_hits(): the number of nearest hits kept for each ray.
  std::uint32_t max_hits = 256;
  /// For list_hits(): no block begins after this many hits are listed.
  std::size_t hits_at_once = std::numeric_limits<std::size_t>::max();
  /// Checked before every block. Once true, no further block begins.
  const std::atomic<bool>* cancelled = nullptr;
  /// For Growth::kFull: receives the progress of the build. Must outlive the batch.
  BuildProgress* progress = nullptr;
};

/// Rays of one block. A block is one task, and the unit of cancelling.
inline constexpr std::size_t kRaysPerBlock = 512;
/// Most rays of one block that lists hits.
inline constexpr std::size_t kRaysPerListBlock = 64;
/// Most hits of one such block, unless a single ray has more.
inline constexpr std::size_t kHitsPerListBlock = 16384;

}  // namespace sightline::scenegraph::query
