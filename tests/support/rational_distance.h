// The distance of a point from a face by its definition, in exact arithmetic: the reference for
// closest points. Shares no code with the product, and none of the identities that it uses.
#pragma once

#include <array>

#include "accel/geometry/vec3.h"

namespace sightline::tests {

/// A point as the distance rule reads it: components below 2^-250 in magnitude are zero.
accel::geometry::Vec3d without_tiny(const accel::geometry::Vec3d& p);

/// The distance of p from the hull of M a, M b and M c, where M is `world_from_local`, rows of
/// [linear | translation]. Numbers are exact reals and must be finite; the result is rounded once,
/// to nearest, ties to even. A face without area is the segment or the point that it is.
/// Threads: any, whose denormal numbers are not flushed to zero.
double rational_distance(const accel::geometry::Vec3d& p,
                         const std::array<double, 12>& world_from_local,
                         const accel::geometry::Vec3f& a, const accel::geometry::Vec3f& b,
                         const accel::geometry::Vec3f& c);

}  // namespace sightline::tests
