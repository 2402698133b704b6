// The distance rule in integers of any length: what doubles and double-doubles do not decide.
#pragma once

#include <array>

#include "accel/geometry/closest.h"

namespace sightline::accel::geometry {

/// As distance(), for a p whose small coordinates are zero already.
double exact_distance(const Vec3d& p, const std::array<double, 12>& world_from_local,
                      const std::array<Vec3f, 3>& vertices);

/// As closest_point(), likewise. Coordinates and weights are rounded once.
ClosestPoint exact_closest_point(const Vec3d& p, const std::array<double, 12>& world_from_local,
                                 const std::array<Vec3f, 3>& vertices);

}  // namespace sightline::accel::geometry
