// Carrying a packet of rays into the frame of an instance.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "accel/geometry/ray.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// Rays as they were asked, in columns.
struct GivenRays {
  std::array<Column<double>, 3> origin, direction;
  Column<double> tmin, tmax;
};

/// Sets the columns from at most kLanes rays, at least one; the others repeat the last.
void read(std::span<const geometry::Ray> rays, GivenRays& out);

/// The rays of `lanes` that are valid: their limits are numbers, and geometry::set_local_ray
/// succeeds relative to `center`.
std::uint32_t valid(const GivenRays& given, const geometry::Vec3d& center, std::uint32_t lanes);

/// A 3x4 matrix by rows, as of an affine transform.
using Matrix = std::array<double, 12>;

/// Sets `out`: origin, direction and unit as geometry::set_local_ray does for each transformed ray,
/// bit for bit; the limits are the same. Returns those of `lanes` for which that succeeds.
std::uint32_t carry(const GivenRays& given, const Matrix& matrix, std::uint32_t lanes, Rays& out);

/// As carry() for a translation by -center.
std::uint32_t center(const GivenRays& given, const geometry::Vec3d& center, std::uint32_t lanes,
                     Rays& out);

}  // namespace sightline::accel::wide
