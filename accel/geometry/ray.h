// A ray query and its answer, as used by the scene level and the wire.
#pragma once

#include <cstdint>
#include <limits>

#include "accel/geometry/vec3.h"

namespace sightline::accel::geometry {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr std::uint32_t kAllMasks = 0xffffffffu;

/// Points origin + t * direction with tmin <= t <= tmax (both closed).
/// The direction need not be a unit vector; t counts in its length.
struct Ray {
  Vec3d origin;
  Vec3d direction;
  double tmin = 0;
  double tmax = kInfinity;
  std::uint32_t mask = kAllMasks;  ///< A node is visible where (node mask & ray mask) != 0.
};

/// 3 is a mark of lists on the wire.
enum class HitState : std::uint8_t { kMiss = 0, kHit = 1, kInvalid = 2, kUnanswered = 4 };

/// The answer to one ray. A miss has t = +inf and node = 0; an invalid ray (NaN, infinite or zero
/// direction, ...) has t = NaN and node = 0; a ray for which there was no time has t = -inf and
/// node = 0.
struct Hit {
  double t = kInfinity;         ///< The distance in units of the direction's length.
  std::uint64_t node = 0;       ///< Node id in the scene; never 0 for a hit.
  std::uint32_t primitive = 0;  ///< Face index in the node's mesh.
  float u = 0;                  ///< Weight of the face's vertex 1.
  float v = 0;                  ///< Weight of the face's vertex 2.
  /// The geometric normal of length 1 in scene coordinates, by the winding in the mesh's frame.
  Vec3f normal;
  std::uint32_t work =
      0;  ///< Traversal steps plus triangle tests spent on this ray; see kWorkDeferred.
  HitState state = HitState::kMiss;
};

/// Flag in Hit::work: the ray met a cell that is not built yet.
inline constexpr std::uint32_t kWorkDeferred = 0x80000000u;

}  // namespace sightline::accel::geometry
