// Checks and counts of a grid of points.
#include "proto/rays/point_grid.h"

#include <fmt/format.h>

#include <cmath>

#include "proto/rays/checks.h"

namespace sightline::proto::rays {
namespace {

std::uint64_t total_of(const PointGrid& grid) {
  return std::uint64_t{grid.columns} * grid.rows * grid.layers;
}

}  // namespace

std::optional<Problem> check(const PointGrid& grid) {
  if (Found found = check_numbers("origin", grid.origin)) return found;
  if (Found found = check_numbers("across", grid.across)) return found;
  if (Found found = check_numbers("down", grid.down)) return found;
  if (Found found = check_numbers("deep", grid.deep)) return found;
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
