// Points that are made here as the server makes them.
#include "client/points.h"

#include <algorithm>

namespace sightline::client {

Result<std::vector<double>> make_points(const PointGrid& grid) {
  if (const auto problem = proto::rays::check(grid))
    return Error{Code::kInvalidArgument, problem->message, problem->reason};
  const std::size_t n = proto::rays::count_of(grid);
  std::vector<double> positions(3 * n);
  proto::rays::make_points(grid, 0, n, [&](std::size_t i, const proto::rays::Vector& point) {
    std::copy(point.begin(), point.end(), &positions[3 * i]);
  });
  return positions;
}

}  // namespace sightline::client
