// Decodes the ray columns of a request.
#include "server/queries/ray_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/exec/rpc_status.h"

namespace sightline::server::queries {
namespace {

static_assert(std::endian::native == std::endian::little,
              "columns are little-endian and are read as they are");

using accel::geometry::Ray;
using accel::geometry::RayColumns;

const char* name_of_element(std::size_t bytes) {
  return bytes == sizeof(double) ? "float64" : "float32";
}

/// Checks that the number of rays that the request says, if it says one, is that of its bytes.
Status check_said_count(const v1::Rays& columns, std::size_t rays, std::size_t element) {
  if (columns.count() == 0 || columns.count() == rays) return {};
  return exec::invalid_argument(
      fmt::format("count says {} rays, but the {} bytes of column origins hold {}, of 3 {} each",
                  columns.count(), columns.origins().size(), rays, name_of_element(element)),
      "RAY_COUNT");
}

Status check_columns(const v1::Rays& columns, std::size_t rays, std::size_t element) {
  const auto check = [&](std::string_view name, const std::string& column, std::size_t bytes) {
    return check_column(name, column, rays, bytes, "rays", "origins");
  };
  const auto check_optional = [&](std::string_view name, const std::string& column,
                                  std::size_t bytes) {
    return column.empty() ? Status() : check(name, column, bytes);
  };
  if (Status s = check("directions", columns.directions(), 3 * element); !s) return s;
  if (Status s = check_optional("tmin", columns.tmin(), element); !s) return s;
  if (Status s = check_optional("tmax", columns.tmax(), element); !s) return s;
  return check_optional("masks", columns.masks(), sizeof(std::uint32_t));
}

}  // namespace

Result<std::size_t> count_rays(const v1::Rays& columns) {
  const std::size_t element = columns.float64() ? sizeof(double) : sizeof(float);
  const std::size_t count = columns.origins().size() / (3 * element);
  if (const Status good = check_said_count(columns, count, element); !good) return good.error();
  if (columns.origins().size() % (3 * element) != 0) {
    return exec::invalid_argument(
        fmt::format("column origins has {} bytes, expected a multiple of {} (3 {} a ray)",
                    columns.origins().size(), 3 * element, name_of_element(element)),
        "COLUMN_LENGTH");
  }
  if (const Status good = check_count(count); !good) return good.error();
  if (const Status good = check_columns(columns, count, element); !good) return good.error();
  return count;
}

Status check_column(std::string_view name, const std::string& column, std::size_t count,
                    std::size_t bytes, std::string_view elements, std::string_view by) {
  if (column.size() == count * bytes) return {};
  return exec::invalid_argument(
      fmt::format("column {} has {} bytes, expected {} ({} {} of {} bytes, by the length of {})",
                  name, column.size(), count * bytes, count, elements, bytes, by),
      "COLUMN_LENGTH");
}

std::size_t max_shared_rays(std::uint64_t max_rays_queued) {
  constexpr std::uint64_t kShareOfQueue = 4;
  return std::clamp<std::uint64_t>(max_rays_queued / kShareOfQueue, kMaxRaysPerRequest,
                                   kMaxSharedRays);
}

Status check_count(std::uint64_t rays, std::size_t most) {
  if (rays <= most) return {};
  return Error{
      Code::kResourceExhausted,
      fmt::format(
          "the request has {} rays, the limit is {}; send more requests or use StreamCastRays",
          rays, most),
      "TOO_MANY_RAYS"};
}

RayColumns view_rays(const v1::Rays& columns, std::size_t first, std::size_t count) {
  const bool float64 = columns.float64();
  const std::size_t element = float64 ? sizeof(double) : sizeof(float);
  RayColumns rays;
  rays.size = count;
  rays.origin =
      accel::geometry::columns_of_rows(columns.origins().data() + 3 * first * element, float64);
  rays.direction =
      accel::geometry::columns_of_rows(columns.directions().data() + 3 * first * element, float64);
  if (!columns.tmin().empty()) rays.tmin = {columns.tmin().data() + first * element, 1, float64};
  if (!columns.tmax().empty()) rays.tmax = {columns.tmax().data() + first * element, 1, float64};
  if (!columns.masks().empty())
    rays.mask = {columns.masks().data() + first * sizeof(std::uint32_t), 1};
  return rays;
}

void decode_rays(const v1::Rays& columns, std::size_t first, std::span<Ray> rays) {
  const RayColumns view = view_rays(columns, first, rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i] = view[i];
}

}  // namespace sightline::server::queries
