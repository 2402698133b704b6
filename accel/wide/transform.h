// Transforms a packet of rays into the frame of an instance.
#pragma once

#include <array>
#include <cstdint>

#include "accel/geometry/vec3.h"
#include "accel/wide/given_rays.h"
#include "accel/wide/packet.h"
#include "accel/wide/placed_mesh.h"

namespace sightline::accel::wide {

/// The rays of `lanes` that are valid: their limits are numbers, and geometry::set_local_ray
/// succeeds relative to `center`.
std::uint32_t valid(const GivenRays& given, const geometry::Vec3d& center, std::uint32_t lanes);

/// Transforms rays: sets origin, direction and unit as geometry::set_local_ray does for each
/// transformed ray, bit for bit, and copies the limits. Returns the rays of `lanes` for which that
/// succeeds.
std::uint32_t transform(const GivenRays& given, const Matrix& matrix, std::uint32_t lanes,
                        Rays& out);
/// Does so by a matrix for each ray.
std::uint32_t transform(const GivenRays& given, const Column<const Matrix*>& matrices,
                        std::uint32_t lanes, Rays& out);

/// Translates rays by -center, as transform() does with a matrix.
std::uint32_t center(const GivenRays& given, const geometry::Vec3d& center, std::uint32_t lanes,
                     Rays& out);

}  // namespace sightline::accel::wide
