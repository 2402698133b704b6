// A ray prepared for one tree, and its tests against boxes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "accel/geometry/aabb.h"
#include "accel/geometry/intersect.h"
#include "accel/geometry/local_ray.h"

namespace sightline::accel::kdtree {

/// A ray prepared for one tree.
///
/// No cell with a hit is missed: a plane's t is computed with a relative error of 3 * 2^-53, a
/// hit's t with an error of kHitError times the distance, and `slack` is above both for any t
/// inside the tree's bounds. Intervals are only widened by it.
struct TreeRay {
  const geometry::LocalRay* local = nullptr;  ///< Must outlive this.
  geometry::Vec3d inverse;             ///< 1 / direction; infinite where the direction is zero.
  std::array<std::size_t, 3> first{};  ///< Child that the ray meets first along each axis.
  double slack = 0;
  double t_in = 0,
         t_out = 0;  ///< Interval of t inside both the bounds and the limits, widened by slack.
};

/// Prepares `out`. Returns false if the ray cannot meet the bounds between tmin and tmax (local
/// units).
inline bool enter(const geometry::LocalRay& ray, const geometry::Aabb& bounds, double tmin,
                  double tmax, TreeRay& out) {
  out.local = &ray;
  double distance = 0;
  double t_in = -std::numeric_limits<double>::infinity(),
         t_out = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < 3; ++a) {
    const double o = ray.origin[a], d = ray.direction[a];
    const double lo = static_cast<double>(bounds.lo[a]) - o,
                 hi = static_cast<double>(bounds.hi[a]) - o;
    distance = std::max(distance, std::max(std::fabs(lo), std::fabs(hi)));
    out.inverse[a] = 1 / d;
    out.first[a] = std::signbit(d) ? 1u : 0u;
    if (d == 0) {
      if (lo > 0 || hi < 0) return false;
      continue;
    }
    const double near = (out.first[a] == 1 ? hi : lo) * out.inverse[a],
                 far = (out.first[a] == 1 ? lo : hi) * out.inverse[a];
    t_in = std::max(t_in, near);
    t_out = std::min(t_out, far);
  }
  out.slack = distance * (4 * geometry::kHitError);
  out.t_in = std::max(t_in, tmin) - out.slack;
  out.t_out = std::min(t_out, tmax) + out.slack;
  return out.t_in <= out.t_out;
}

/// Whether the ray may meet a box between its t_in and `limit`; never false for a box that it
/// meets. This serves searches of the lists of deferred cells.
inline bool may_meet(const TreeRay& ray, const geometry::Aabb& box, double limit) {
  double t_in = ray.t_in, t_out = std::min(ray.t_out, limit);
  for (std::size_t a = 0; a < 3; ++a) {
    const double lo = (static_cast<double>(box.lo[a]) - ray.local->origin[a]) * ray.inverse[a];
    const double hi = (static_cast<double>(box.hi[a]) - ray.local->origin[a]) * ray.inverse[a];
    const double near = (ray.first[a] == 1 ? hi : lo) - ray.slack,
                 far = (ray.first[a] == 1 ? lo : hi) + ray.slack;
    // A ray in the plane of a face has NaN here, which fails both tests.
    if (near > t_in) t_in = near;
    if (far < t_out) t_out = far;
  }
  return t_in <= t_out;
}

}  // namespace sightline::accel::kdtree
