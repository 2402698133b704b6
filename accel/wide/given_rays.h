// The rays of a packet as the caller gave them.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "accel/geometry/ray_columns.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// The given rays in aligned columns.
struct GivenRays {
  std::array<Column<double>, 3> origin, direction;
  Column<double> tmin, tmax;
};

/// Reads `count` rays of a batch, 1 to kLanes, the first one at index `first`. Lanes behind them
/// repeat the last.
void read(const geometry::RayColumns& rays, std::size_t first, std::size_t count, GivenRays& out);

/// Reads all of these rays, 1 to kLanes.
inline void read(std::span<const geometry::Ray> rays, GivenRays& out) {
  read(geometry::columns_of(rays), 0, rays.size(), out);
}

}  // namespace sightline::accel::wide
