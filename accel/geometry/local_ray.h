// A ray in the frame of a tree, brought into a range where the exact arithmetic of the hit rule can
// neither overflow nor underflow.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include "accel/geometry/vec3.h"

namespace sightline::accel {

/// Coordinates beyond kLargest are no rays; components below kSmallest are taken as zero.
inline constexpr double kLargestRay = 0x1p+250;
inline constexpr double kSmallestRay = 0x1p-250;

/// The direction is scaled by a power of two so that its largest component lies in [1, 2).
/// A local t is `t / unit`, where t counts in the original direction's length; both ways are exact.
struct LocalRay {
  Vec3d origin;
  Vec3d direction;
  double unit = 1;
};

/// Nothing for a direction that is zero or not finite, or an origin out of range.
inline std::optional<LocalRay> make_local_ray(Vec3d origin, Vec3d direction) {
  const double largest =
      std::max({std::fabs(direction.x), std::fabs(direction.y), std::fabs(direction.z)});
  if (!is_finite(direction) || !is_finite(origin) || !(largest > 0)) return std::nullopt;
  const auto exponent = static_cast<int>(std::bit_cast<std::uint64_t>(largest) >> 52) - 1023;
  // A direction this short or long has no use, and its unit would not be a normal double.
  if (exponent < -1000 || exponent > 1000) return std::nullopt;
  LocalRay ray;
  ray.unit = std::bit_cast<double>(static_cast<std::uint64_t>(1023 - exponent) << 52);
  for (std::size_t a = 0; a < 3; ++a) {
    if (std::fabs(origin[a]) > kLargestRay) return std::nullopt;
    ray.origin[a] = std::fabs(origin[a]) < kSmallestRay ? 0.0 : origin[a];
    const double d = direction[a] * ray.unit;
    ray.direction[a] = std::fabs(d) < kSmallestRay ? 0.0 : d;
  }
  return ray;
}

}  // namespace sightline::accel
