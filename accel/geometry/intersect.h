// The hit rule: whether a ray meets a triangle, and where. A pure function of the two, the same
// whichever cell, builder, thread or SIMD target led to the question. docs/hit_rule.md has the
// argument.
#pragma once

#include <optional>

#include "accel/geometry/local_ray.h"

namespace sightline::accel {

/// t of the hit in local units (see LocalRay), or nothing. t may be negative: limits are the
/// caller's.
///
/// A hit is decided by the exact signs of det[d, a - o, b - o] over the three edges: all the same
/// is a hit. A zero is resolved as if the origin were moved by (e, e^2, e^3) for an infinitely
/// small e > 0, so an edge in the interior of a surface has one owner and a silhouette edge none or
/// two. A triangle seen edge-on, or without area, is never hit. t is off by at most kHitError times
/// the largest |v - o| of its vertices (maximum norm). Vertices must be finite.
std::optional<double> intersect(const LocalRay& ray, const Vec3f& a, const Vec3f& b,
                                const Vec3f& c);

inline constexpr double kHitError = 0x1p-30;

/// Weights of vertices 1 and 2 at a hit; both >= 0, sum <= 1.
struct Barycentric {
  double u = 0, v = 0;
};
Barycentric barycentric(const LocalRay& ray, double t, const Vec3f& a, const Vec3f& b,
                        const Vec3f& c);

}  // namespace sightline::accel
