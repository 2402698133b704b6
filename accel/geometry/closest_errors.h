// How far double-doubles are off in the distance rule: docs/distance_rule.md, sections 5 and 7.
#pragma once

#include <algorithm>
#include <cmath>

#include "accel/geometry/local_ray.h"
#include "accel/geometry/seen_face.h"

namespace sightline::accel::geometry {

inline double square(const Vec3dd& v) { return dot(high(v), high(v)); }

/// The largest distance of a corner.
inline double reach(const SeenFace& face) {
  return std::sqrt(
      std::max({square(face.corner[0]), square(face.corner[1]), square(face.corner[2])}));
}

/// |e_2| |e_0| / |N|: how much larger relative errors are in N than in its terms.
inline double thinness(const SeenFace& face, const Vec3dd& normal) {
  return std::sqrt(square(face.edge[2]) * square(face.edge[0]) / square(normal));
}

inline double shortest_edge(const SeenFace& face) {
  return std::sqrt(std::min({square(face.edge[0]), square(face.edge[1]), square(face.edge[2])}));
}

/// How far the computed nearest point may be off, inside or on an edge: what the errors of the
/// corners and of double-doubles make of it, for a shortest edge of this length.
inline double spread(const SeenFace& face, double thinness, double shortest) {
  const double largest = reach(face);
  return 16 * (face.error + 0x1p-98 * largest) * thinness * (1 + largest / shortest);
}

/// A point as the rule reads it: coordinates below kSmallestRay count as zero.
inline Vec3d without_smallest(const Vec3d& p) {
  const auto flushed = [](double x) { return std::fabs(x) < kSmallestRay ? 0.0 : x; };
  return {flushed(p.x), flushed(p.y), flushed(p.z)};
}

/// a + p, rounded.
inline Vec3d rounded_sum(const Vec3dd& a, const Vec3d& p) {
  const auto sum = [](const DoubleDouble& x, double y) { return (x + DoubleDouble{y}).high; };
  return {sum(a.x, p.x), sum(a.y, p.y), sum(a.z, p.z)};
}

}  // namespace sightline::accel::geometry
