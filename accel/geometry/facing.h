// Which side of a triangle a ray meets.
#pragma once

#include <cstdint>

#include "accel/geometry/local_ray.h"

namespace sightline::accel::geometry {

/// Which side of triangles a query ignores. Seen from the front, the corners run counterclockwise.
enum class Culling : std::uint8_t { kNone, kBack, kFront };

/// The exact sign of N . d with N = (b - a) x (c - a): -1 where the ray meets the front, 1 where it
/// meets the back, 0 where it runs edge-on (never the case for a hit). Vertices must be finite.
int facing(const LocalRay& ray, const Vec3f& a, const Vec3f& b, const Vec3f& c);

/// Whether the query ignores a hit of this triangle.
inline bool is_culled(Culling culling, const LocalRay& ray, const Vec3f& a, const Vec3f& b,
                      const Vec3f& c) {
  return culling != Culling::kNone && facing(ray, a, b, c) == (culling == Culling::kBack ? 1 : -1);
}

}  // namespace sightline::accel::geometry
