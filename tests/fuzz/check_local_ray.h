// Checks make_local_ray against its contract: what it refuses, scales and drops.
#pragma once

#include <optional>
#include <string>

#include "accel/geometry/vec3.h"

namespace sightline::tests {

/// Describes an error, or nothing. Origin and direction may be any finite vectors.
std::optional<std::string> check_local_ray(const accel::geometry::Vec3d& origin,
                                           const accel::geometry::Vec3d& direction);

}  // namespace sightline::tests
