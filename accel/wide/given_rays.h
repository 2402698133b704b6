// The rays of a packet as they were asked.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "accel/geometry/ray_columns.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// In aligned columns.
struct GivenRays {
  std::array<Column<double>, 3> origin, direction;
  Column<double> tmin, tmax;
};

/// Sets the columns from `count` rays of a batch, the first on; at least one and at most kLanes,
/// and the others repeat the last.
void read(const geometry::RayColumns& rays, std::size_t first, std::size_t count, GivenRays& out);

/// From all of these rays.
inline void read(std::span<const geometry::Ray> rays, GivenRays& out) {
  read(geometry::columns_of(rays), 0, rays.size(), out);
}

}  // namespace sightline::accel::wide
