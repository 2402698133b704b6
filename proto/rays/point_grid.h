// Points in equal steps along three directions. Client and server share them, so that both make the
// same points, bit by bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "proto/rays/generator.h"

namespace sightline::proto::rays {

/// Point i is origin + x across + y down + z deep, with i = x + columns (y + rows z).
struct PointGrid {
  Vector origin{}, across{}, down{}, deep{};
  std::uint32_t columns = 0, rows = 0, layers = 1;  ///< 1 to kMaxSide
  std::uint64_t first = 0;                          ///< The first point that is asked for.
  std::uint64_t count = 0;                          ///< How many are; 0: all from `first` on.
  double max_distance = std::numeric_limits<double>::infinity();  ///< Every point's.
  std::uint32_t mask = 0xffffffffu;
};

/// Checks every number. Returns nothing if all is well.
std::optional<Problem> check(const PointGrid& grid);

/// How many points are asked for of a grid in which check() has found nothing.
std::uint64_t count_of(const PointGrid& grid);

/// Calls put(i, point), a Vector, with point first + i of those that are asked for, for every i
/// below `count`.
template <class Put>
void make_points(const PointGrid& grid, std::size_t first, std::size_t count, const Put& put) {
  std::uint64_t at = grid.first + first;
  for (std::size_t i = 0; i < count; ++i, ++at) {
    const auto x = static_cast<double>(at % grid.columns),
               y = static_cast<double>(at / grid.columns % grid.rows),
               z = static_cast<double>(at / grid.columns / grid.rows);
    Vector point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      point[axis] =
          grid.origin[axis] + x * grid.across[axis] + y * grid.down[axis] + z * grid.deep[axis];
    }
    put(i, point);
  }
}

}  // namespace sightline::proto::rays
