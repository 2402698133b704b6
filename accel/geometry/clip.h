// The bounds of the part of a triangle that lies in a cell.
#pragma once

#include <optional>

#include "accel/geometry/aabb.h"

namespace sightline::accel::geometry {

/// Holds every point of the triangle that lies in the closed cell, and hardly more: never
/// too small, by rounding and widen_flat a few floats too large. Nothing if they do not meet. The
/// result went through widen_flat. Vertices must be finite.
std::optional<Aabb> clipped_bounds(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                   const Aabb& cell);

/// The area of that part, to the precision of double. Vertices must be finite.
double clipped_area(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Aabb& cell);

}  // namespace sightline::accel::geometry
