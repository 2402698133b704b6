// Holds make_local_ray to its word: what it refuses, what it scales, what it drops.
#pragma once

#include <optional>
#include <string>

#include "accel/geometry/vec3.h"

namespace sightline::tests {

/// What is wrong, or nothing. Origin and direction may be anything but NaN and infinite.
std::optional<std::string> check_local_ray(const accel::geometry::Vec3d& origin,
                                           const accel::geometry::Vec3d& direction);

}  // namespace sightline::tests
