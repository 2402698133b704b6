// Checks and counts of a grid of points.
#include "proto/rays/point_grid.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

namespace sightline::proto::rays {
namespace {

using Found = std::optional<Problem>;

Found check_vector(std::string_view name, const Vector& vector) {
  for (const double number : vector) {
    if (!std::isfinite(number))
      return Problem{fmt::format("{} holds {}, which is not finite", name, number), "NOT_FINITE"};
  }
  return {};
}

Found check_side(std::string_view name, std::uint32_t side) {
  if (side >= 1 && side <= kMaxSide) return {};
  return Problem{fmt::format("{} is {}, not from 1 to {}", name, side, kMaxSide), "BAD_SIZE"};
}

std::uint64_t total_of(const PointGrid& grid) {
  return std::uint64_t{grid.columns} * grid.rows * grid.layers;
}

}  // namespace

std::optional<Problem> check(const PointGrid& grid) {
  if (Found found = check_vector("origin", grid.origin)) return found;
  if (Found found = check_vector("across", grid.across)) return found;
  if (Found found = check_vector("down", grid.down)) return found;
  if (Found found = check_vector("deep", grid.deep)) return found;
  if (Found found = check_side("columns", grid.columns)) return found;
  if (Found found = check_side("rows", grid.rows)) return found;
  if (Found found = check_side("layers", grid.layers)) return found;
  if (std::isnan(grid.max_distance)) return Problem{"max_distance is nan", "NOT_FINITE"};
  const std::uint64_t total = total_of(grid);
  if (grid.first <= total && grid.count <= total - grid.first) return {};
  return Problem{fmt::format("points {} and the next {} are asked for, but the grid has {}",
                             grid.first, grid.count, total),
                 "NO_SUCH_POINTS"};
}

std::uint64_t count_of(const PointGrid& grid) {
  return grid.count == 0 ? total_of(grid) - grid.first : grid.count;
}

}  // namespace sightline::proto::rays
