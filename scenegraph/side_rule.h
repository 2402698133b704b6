// What is asked of a point's side, and what rays from it say.
#pragma once

#include <cstdint>

#include "accel/geometry/vec3.h"

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

/// Whether one ray of kParity or kWinding says inside. `crossings` modulo 2^32: kParity: the faces
/// that it crosses; kWinding: those that it meets from the front, less those that it meets from
/// behind. Those of several parts of a scene add up.
inline bool says_inside(SideRule rule, std::uint32_t crossings) {
  return rule == SideRule::kParity ? crossings % 2 == 1 : crossings != 0;
}

/// What the votes say of a point: the rays that say inside, of all.
inline Side majority(std::uint32_t votes, std::uint32_t rays) {
  return 2 * votes > rays ? Side::kInside : Side::kOutside;
}

/// The direction of a side ray of kParity or kWinding, of length 1. `ray`: below kMaxSideRays.
const accel::geometry::Vec3d& side_direction(std::uint32_t ray);

}  // namespace sightline::scenegraph
