// Decodes the ray columns of a request.
#include "server/queries/ray_codec.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "server/exec/rpc_status.h"

namespace sightline::server::queries {
namespace {

static_assert(std::endian::native == std::endian::little,
              "columns are little-endian and are copied as they are");

using accel::geometry::Ray;

template <class T>
T load(const std::string& column, std::size_t row) {
  T value;
  std::memcpy(&value, column.data() + row * sizeof(T), sizeof(T));
  return value;
}

template <class T>
accel::geometry::Vec3d load_vector(const std::string& column, std::size_t row) {
  const auto v = load<std::array<T, 3>>(column, row);
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

/// The columns are of the right lengths, and have rows up to first + rays.size().
template <class T>
void fill(const v1::Rays& columns, std::size_t first, std::span<Ray> rays) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i] = {.origin = load_vector<T>(columns.origins(), first + i),
               .direction = load_vector<T>(columns.directions(), first + i)};
  }
  if (!columns.tmin().empty()) {
    for (std::size_t i = 0; i < rays.size(); ++i)
      rays[i].tmin = static_cast<double>(load<T>(columns.tmin(), first + i));
  }
  if (!columns.tmax().empty()) {
    for (std::size_t i = 0; i < rays.size(); ++i)
      rays[i].tmax = static_cast<double>(load<T>(columns.tmax(), first + i));
  }
  if (!columns.masks().empty()) {
    for (std::size_t i = 0; i < rays.size(); ++i)
      rays[i].mask = load<std::uint32_t>(columns.masks(), first + i);
  }
}

Status check_column(std::string_view name, const std::string& column, std::size_t rays,
                    std::size_t bytes_per_ray) {
  if (column.size() == rays * bytes_per_ray) return {};
  return exec::invalid_argument(
      fmt::format(
          "column {} has {} bytes, expected {} ({} rays of {} bytes, by the length of origins)",
          name, column.size(), rays * bytes_per_ray, rays, bytes_per_ray),
      "COLUMN_LENGTH");
}

Status check_optional_column(std::string_view name, const std::string& column, std::size_t rays,
                             std::size_t bytes_per_ray) {
  return column.empty() ? Status() : check_column(name, column, rays, bytes_per_ray);
}

Status check_columns(const v1::Rays& columns, std::size_t rays, std::size_t element) {
  if (Status s = check_column("directions", columns.directions(), rays, 3 * element); !s) return s;
  if (Status s = check_optional_column("tmin", columns.tmin(), rays, element); !s) return s;
  if (Status s = check_optional_column("tmax", columns.tmax(), rays, element); !s) return s;
  return check_optional_column("masks", columns.masks(), rays, sizeof(std::uint32_t));
}

}  // namespace

Result<std::size_t> count_rays(const v1::Rays& columns) {
  const std::size_t element = columns.float64() ? sizeof(double) : sizeof(float);
  const std::size_t count = columns.origins().size() / (3 * element);
  if (columns.origins().size() % (3 * element) != 0) {
    return exec::invalid_argument(
        fmt::format("column origins has {} bytes, expected a multiple of {} (3 {} a ray)",
                    columns.origins().size(), 3 * element,
                    columns.float64() ? "float64" : "float32"),
        "COLUMN_LENGTH");
  }
  if (const Status good = check_count(count); !good) return good.error();
  if (const Status good = check_columns(columns, count, element); !good) return good.error();
  return count;
}

Status check_count(std::size_t rays) {
  if (rays <= kMaxRaysPerRequest) return {};
  return Error{
      Code::kResourceExhausted,
      fmt::format(
          "the request has {} rays, the limit is {}; send more requests or use StreamCastRays",
          rays, kMaxRaysPerRequest),
      "TOO_MANY_RAYS"};
}

void decode_rays(const v1::Rays& columns, std::size_t first, std::span<Ray> rays) {
  if (columns.float64()) {
    fill<double>(columns, first, rays);
  } else {
    fill<float>(columns, first, rays);
  }
}

}  // namespace sightline::server::queries
