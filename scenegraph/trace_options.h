// What a batch of rays asks for.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "accel/geometry/facing.h"

namespace sightline::scenegraph::instances {
class Selection;
}
namespace sightline::scenegraph::query {
struct BuildProgress;
}

namespace sightline::scenegraph {

/// All kinds see the same hits, so that any == (count > 0) == (closest is a hit) == (all is not
/// empty), whatever limits, masks, culling and selection are set.
enum class QueryKind : std::uint8_t {
  kClosest,  ///< The hit with the smallest (t, node, primitive).
  kAny,      ///< Whether there is a hit.
  kCount,    ///< How many distinct (node, primitive) are hit.
  kAll,      ///< Every hit by (t, node, primitive), each (node, primitive) once.
};

/// How much tree a batch may grow.
enum class Growth : std::uint8_t {
  kFirstTouch,  ///< A cell is expanded by the first ray that enters it.
  kFull,        ///< Everything is built before the first ray.
  kNone,        ///< Nothing is grown; what is not built is searched triangle by triangle.
  kBuiltOnly,   ///< Nothing is grown and what is not built is passed over: shows what exists,
                ///< answers no query.
};

struct TraceOptions {
  QueryKind kind = QueryKind::kClosest;  ///< Of trace(): kClosest or kAny.
  Growth growth = Growth::kFirstTouch;
  /// Barycentrics and normals are computed only if asked for.
  bool surface = true;
  /// By the winding in scene coordinates, as normals are: a mirrored instance turns its mesh's
  /// windings around. Hits that are culled do not exist for any kind.
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  /// The nodes that rays see, of this very snapshot; null: all. Must outlive the batch.
  const instances::Selection* selection = nullptr;
  /// Of list_hits(), for each ray: the nearest are kept.
  std::uint32_t max_hits = 256;
  /// Of list_hits(): no block is begun once so many hits are listed.
  std::size_t hits_at_once = std::numeric_limits<std::size_t>::max();
  /// Checked before every block; once true, no further block is begun.
  const std::atomic<bool>* cancelled = nullptr;
  /// Of Growth::kFull: told how far the building has come. Must outlive the batch.
  query::BuildProgress* progress = nullptr;
};

}  // namespace sightline::scenegraph
