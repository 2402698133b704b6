// A ray in the frame of a tree, brought into a range where the exact arithmetic of the hit rule can
// neither overflow nor underflow.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include "accel/geometry/vec3.h"

namespace sightline::accel::geometry {

/// A ray with a coordinate beyond kLargestRay is invalid; components below kSmallestRay are taken
/// as zero.
inline constexpr double kLargestRay = 0x1p+250;
inline constexpr double kSmallestRay = 0x1p-250;

/// The direction is scaled by a power of two so that its largest component lies in [1, 2).
/// A local t is `t / unit`, where t counts in the original direction's length; both ways are exact.
struct LocalRay {
  Vec3d origin;
  Vec3d direction;
  double unit = 1;
};

/// Sets the origin alone; false if it is not finite or out of range.
inline bool set_local_origin(const Vec3d& origin, LocalRay& ray) {
  const double most = std::max({std::fabs(origin.x), std::fabs(origin.y), std::fabs(origin.z)});
  if (!is_finite(origin) || most > kLargestRay) return false;
  const auto flushed = [](double x) { return std::fabs(x) < kSmallestRay ? 0.0 : x; };
  ray.origin.x = flushed(origin.x);
  ray.origin.y = flushed(origin.y);
  ray.origin.z = flushed(origin.z);
  return true;
}

/// Sets `ray`; false for a direction that is zero or not finite, or an origin out of range.
///
/// Numbers are written directly to `ray`: the traversal reads them at once, and a load that is
/// wider than the stores before it would wait for them (store forwarding fails).
inline bool set_local_ray(const Vec3d& origin, const Vec3d& direction, LocalRay& ray) {
  const double most =
      std::max({std::fabs(direction.x), std::fabs(direction.y), std::fabs(direction.z)});
  if (!is_finite(direction) || !(most > 0)) return false;
  const auto exponent = static_cast<int>(std::bit_cast<std::uint64_t>(most) >> 52) - 1023;
  // The unit of a direction this short or long would not be a normal double.
  if (exponent < -1000 || exponent > 1000 || !set_local_origin(origin, ray)) return false;
  const auto flushed = [](double x) { return std::fabs(x) < kSmallestRay ? 0.0 : x; };
  const double unit = std::bit_cast<double>(static_cast<std::uint64_t>(1023 - exponent) << 52);
  ray.direction.x = flushed(direction.x * unit);
  ray.direction.y = flushed(direction.y * unit);
  ray.direction.z = flushed(direction.z * unit);
  ray.unit = unit;
  return true;
}

/// Returns the ray that set_local_ray() sets, or nothing where that returns false.
inline std::optional<LocalRay> make_local_ray(const Vec3d& origin, const Vec3d& direction) {
  std::optional<LocalRay> ray(std::in_place);
  if (!set_local_ray(origin, direction, *ray)) ray.reset();
  return ray;
}

}  // namespace sightline::accel::geometry
