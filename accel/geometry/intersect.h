// The hit rule: whether a ray meets a triangle, and where. A pure function of ray and triangle: it
// does not depend on the cell, builder, thread or SIMD target. docs/hit_rule.md has the proof.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "accel/geometry/local_ray.h"

namespace sightline::accel::geometry {

/// Returns t of the hit in local units (see LocalRay), or nothing. t may be negative: the caller
/// applies limits.
///
/// A hit is decided by the exact signs of det[d, a - o, b - o] over the three edges: if all are the
/// same, it is a hit. A zero is resolved as if the origin were moved by (e, e^2, e^3) for an
/// infinitely small e > 0, so an edge in the interior of a surface has one owner and a silhouette
/// edge none or two. A triangle seen edge-on, or without area, is never hit. t is off by at most
/// kHitError times the largest |v - o| of its vertices (maximum norm). Vertices must be finite.
inline std::optional<double> intersect(const LocalRay& ray, const Vec3f& a, const Vec3f& b,
                                       const Vec3f& c);

inline constexpr double kHitError = 0x1p-30;

/// Whether a hit, which intersect() gives at t, lies beyond the ray's origin, and not before it:
/// the sign of the exact t. A zero is resolved as the rule does, by the origin o + (e, e^2, e^3).
bool is_ahead(const LocalRay& ray, double t, const Vec3f& a, const Vec3f& b, const Vec3f& c);

/// Weights of vertices 1 and 2 at a hit; both >= 0, sum <= 1. The point they give is off the hit by
/// at most 16 kHitError times the largest |v - o|.
struct Barycentric {
  double u = 0, v = 0;
};
Barycentric barycentric(const LocalRay& ray, double t, const Vec3f& a, const Vec3f& b,
                        const Vec3f& c);

// The first test is inline: most triangles have two certain and opposite signs, which is a miss.
//
// The computed determinant has seven roundings on its longest path, each at most 2^-53 of a term,
// and six terms of at most |d| |p| |q| (maximum norm); |d| < 2. 6 * 2 * 7.1 * 2^-53 < 2^-46.
inline constexpr double kSignError = 0x1p-46;

/// Where |N . d| is below this share of |b - a| |c - a|, t is computed exactly: see kHitError.
inline constexpr double kEdgeOn = 0x1p-16;

inline double max_norm(const Vec3d& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// The decision for a triangle that is not certainly missed, given the computed determinants of ab,
/// bc and ca; NaN: no hit.
double intersect_survivor(const LocalRay& ray, const Vec3f& a, const Vec3f& b, const Vec3f& c,
                          const Vec3d& determinants);

inline std::optional<double> intersect(const LocalRay& ray, const Vec3f& af, const Vec3f& bf,
                                       const Vec3f& cf) {
  const Vec3d pa = Vec3d(af) - ray.origin, pb = Vec3d(bf) - ray.origin, pc = Vec3d(cf) - ray.origin;
  const double ab = dot(ray.direction, cross(pa, pb));
  const double bc = dot(ray.direction, cross(pb, pc));
  const double ca = dot(ray.direction, cross(pc, pa));
  const double n = std::max({max_norm(pa), max_norm(pb), max_norm(pc)});
  const double bound = kSignError * n * n;
  const bool positive = std::max({ab, bc, ca}) > bound;
  const bool negative = std::min({ab, bc, ca}) < -bound;
  if (positive && negative) return std::nullopt;
  const double t = intersect_survivor(ray, af, bf, cf, {ab, bc, ca});
  return std::isnan(t) ? std::nullopt : std::optional(t);
}

}  // namespace sightline::accel::geometry
