// Decodes the points of a request, and grids of them.
#include "server/queries/point_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/exec/rpc_status.h"
#include "server/queries/ray_codec.h"

namespace sightline::server::queries {
namespace {

using accel::geometry::RayColumns;

Status decode_vector(std::string_view name, const google::protobuf::RepeatedField<double>& numbers,
                     proto::rays::Vector& out) {
  if (numbers.size() != static_cast<int>(out.size())) {
    return exec::invalid_argument(
        fmt::format("{} has {} numbers, expected {}", name, numbers.size(), out.size()),
        "NUMBER_COUNT");
  }
  std::copy(numbers.begin(), numbers.end(), out.begin());
  return {};
}

}  // namespace

Result<std::size_t> count_points(const v1::Points& columns) {
  const std::size_t element = columns.float64() ? sizeof(double) : sizeof(float);
  const std::size_t bytes = columns.positions().size(), count = bytes / (3 * element);
  const char* const name = columns.float64() ? "float64" : "float32";
  if (columns.count() != 0 && columns.count() != count) {
    return exec::invalid_argument(
        fmt::format("count says {} points, but the {} bytes of column positions hold {}, of 3 {} "
                    "each",
                    columns.count(), bytes, count, name),
        "POINT_COUNT");
  }
  if (bytes % (3 * element) != 0) {
    return exec::invalid_argument(
        fmt::format("column positions has {} bytes, expected a multiple of {} (3 {} a point)",
                    bytes, 3 * element, name),
        "COLUMN_LENGTH");
  }
  if (const Status good = check_count(count); !good) return good.error();
  const auto check = [&](std::string_view column_name, const std::string& column,
                         std::size_t size) {
    return column.empty() ? Status()
                          : check_column(column_name, column, count, size, "points", "positions");
  };
  if (const Status s = check("max_distance", columns.max_distance(), element); !s) return s.error();
  if (const Status s = check("masks", columns.masks(), sizeof(std::uint32_t)); !s) return s.error();
  return count;
}

RayColumns rays_of_points(const void* positions, bool float64, std::size_t count) {
  static constexpr double kOne = 1, kZero = 0;
  RayColumns rays;
  rays.size = count;
  rays.origin = accel::geometry::columns_of_rows(positions, float64);
  rays.direction = {accel::geometry::for_all(kOne), accel::geometry::for_all(kZero),
                    accel::geometry::for_all(kZero)};
  return rays;
}

RayColumns view_points(const v1::Points& columns, std::size_t first, std::size_t count) {
  const bool float64 = columns.float64();
  const std::size_t element = float64 ? sizeof(double) : sizeof(float);
  RayColumns rays =
      rays_of_points(columns.positions().data() + 3 * first * element, float64, count);
  if (!columns.max_distance().empty())
    rays.tmax = {columns.max_distance().data() + first * element, 1, float64};
  if (!columns.masks().empty())
    rays.mask = {columns.masks().data() + first * sizeof(std::uint32_t), 1};
  return rays;
}

Result<proto::rays::PointGrid> decode_grid(const v1::PointGrid& message) {
  proto::rays::PointGrid grid{.columns = message.columns(),
                              .rows = message.rows(),
                              .layers = std::max(message.layers(), 1u),
                              .first = message.first(),
                              .count = message.count()};
  if (message.has_max_distance()) grid.max_distance = message.max_distance();
  if (message.has_mask()) grid.mask = message.mask();
  if (const Status s = decode_vector("origin", message.origin(), grid.origin); !s) return s.error();
  if (const Status s = decode_vector("across", message.across(), grid.across); !s) return s.error();
  if (const Status s = decode_vector("down", message.down(), grid.down); !s) return s.error();
  if (!message.deep().empty()) {
    if (const Status s = decode_vector("deep", message.deep(), grid.deep); !s) return s.error();
  }
  if (const auto problem = proto::rays::check(grid))
    return exec::invalid_argument(problem->message, problem->reason);
  return grid;
}

}  // namespace sightline::server::queries
