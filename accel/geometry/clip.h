// The bounds of the part of a triangle that lies in a cell.
#pragma once

#include <optional>

#include "accel/geometry/aabb.h"

namespace sightline::accel::geometry {

/// Bounds of the part of a triangle that lies in the closed cell; nothing if they do not meet. The
/// result is never too small; rounding and widen_flat, through which it went, make it a few floats
/// too large. Vertices must be finite.
std::optional<Aabb> clipped_bounds(const Vec3f& a, const Vec3f& b, const Vec3f& c,
                                   const Aabb& cell);

}  // namespace sightline::accel::geometry
