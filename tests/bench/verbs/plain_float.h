// The triangle test that ray tracers usually have: Moller and Trumbore's, in float. It is the
// baseline for the cost and the benefit of exactness.
#pragma once

#include <cmath>
#include <optional>

#include "accel/geometry/local_ray.h"

namespace sightline::bench {

/// T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997. Both sides of
/// a triangle are hit, its edges belong to it, and only a determinant of zero counts as edge-on.
class PlainFloat {
 public:
  /// The ray, rounded to float.
  explicit PlainFloat(const accel::geometry::LocalRay& ray)
      : origin_(ray.origin), direction_(ray.direction) {}

  /// t of the hit in local units, or nothing. t may be negative: the caller checks limits.
  std::optional<double> operator()(const accel::geometry::Vec3f& a, const accel::geometry::Vec3f& b,
                                   const accel::geometry::Vec3f& c) const {
    const accel::geometry::Vec3f e1 = b - a, e2 = c - a;
    const accel::geometry::Vec3f p = cross(direction_, e2);
    const float determinant = dot(e1, p), size = std::fabs(determinant);
    const accel::geometry::Vec3f s = origin_ - a;
    const float u = std::copysign(1.0f, determinant) * dot(s, p);
    if (!(u >= 0 && u <= size)) return std::nullopt;
    const accel::geometry::Vec3f q = cross(s, e1);
    const float v = std::copysign(1.0f, determinant) * dot(direction_, q);
    if (!(v >= 0 && u + v <= size) || determinant == 0) return std::nullopt;
    return static_cast<double>(dot(e2, q) / determinant);
  }

 private:
  accel::geometry::Vec3f origin_, direction_;
};

}  // namespace sightline::bench
