// Checks make_local_ray against its contract.
#include "tests/fuzz/check_local_ray.h"

#include <algorithm>
#include <cmath>

#include "accel/geometry/local_ray.h"
#include "tests/support/rational.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;

double largest(const Vec3d& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// Whether `kept` is exactly x * unit, or zero if that is too small.
bool scaled(double kept, double x, double unit) {
  const Dyadic exact = Dyadic(x) * Dyadic(unit);
  if ((exact.magnitude() - Dyadic(accel::geometry::kSmallestRay)).sign() < 0) return kept == 0;
  return (Dyadic(kept) - exact).sign() == 0;
}

}  // namespace

std::optional<std::string> check_local_ray(const Vec3d& origin, const Vec3d& direction) {
  const auto ray = accel::geometry::make_local_ray(origin, direction);
  // Lengths that no direction has are refused, but nothing within 2^900 of one may be.
  const double length = largest(direction);
  if (!ray) {
    const bool right =
        largest(origin) > accel::geometry::kLargestRay || length < 0x1p-900 || length > 0x1p+900;
    return right ? std::nullopt : std::optional<std::string>("refuses a ray");
  }
  if (largest(origin) > accel::geometry::kLargestRay || length == 0) return "takes what is no ray";
  const double local = largest(ray->direction);
  if (!(local >= 1 && local < 2)) return "does not bring the direction into [1, 2)";
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!scaled(ray->origin[axis], origin[axis], 1)) return "moves the origin";
    if (!scaled(ray->direction[axis], direction[axis], ray->unit)) return "turns the direction";
  }
  return std::nullopt;
}

}  // namespace sightline::tests
