// Decodes ray columns of a request and encodes hit columns of a reply.
#include "server/queries/query_codec.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

#include "server/exec/rpc_status.h"

namespace sightline::server::queries {
namespace {

static_assert(std::endian::native == std::endian::little,
              "columns are little-endian and are copied as they are");

using accel::geometry::Hit;
using accel::geometry::Ray;
using scenegraph::RayTally;

template <class T>
T load(const std::string& column, std::size_t index) {
  T value;
  std::memcpy(&value, column.data() + index * sizeof(T), sizeof(T));
  return value;
}

template <class T>
accel::geometry::Vec3d load_vector(const std::string& column, std::size_t row) {
  const auto v = load<std::array<T, 3>>(column, row);
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

/// The columns are of the right lengths for rays.size() rows.
template <class T>
void fill(const v1::Rays& columns, std::span<Ray> rays) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i].origin = load_vector<T>(columns.origins(), i);
    rays[i].direction = load_vector<T>(columns.directions(), i);
  }
  if (!columns.tmin().empty()) {
    for (std::size_t i = 0; i < rays.size(); ++i)
      rays[i].tmin = static_cast<double>(load<T>(columns.tmin(), i));
  }
  if (!columns.tmax().empty()) {
    for (std::size_t i = 0; i < rays.size(); ++i)
      rays[i].tmax = static_cast<double>(load<T>(columns.tmax(), i));
  }
  if (!columns.masks().empty()) {
    for (std::size_t i = 0; i < rays.size(); ++i)
      rays[i].mask = load<std::uint32_t>(columns.masks(), i);
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

/// One column: `element(row)` for every row, each copied as its bytes.
template <class Row, class Element>
void write_column(std::span<const Row> rows, std::string& data, Element element) {
  using Value = decltype(element(rows[0]));
  static_assert(std::is_trivially_copyable_v<Value>);
  data.resize(rows.size() * sizeof(Value));
  char* out = data.data();
  for (const Row& row : rows) {
    const Value value = element(row);
    std::memcpy(out, &value, sizeof(Value));
    out += sizeof(Value);
  }
}

void write_hits(std::span<const Hit> hits, v1::HitField field, std::string& data) {
  switch (field) {
    case v1::HIT_FIELD_T:
      return write_column(hits, data, [](const Hit& h) { return h.t; });
    case v1::HIT_FIELD_NODE:
      return write_column(hits, data, [](const Hit& h) { return h.node; });
    case v1::HIT_FIELD_PRIMITIVE:
      return write_column(hits, data, [](const Hit& h) { return h.primitive; });
    case v1::HIT_FIELD_BARYCENTRIC:
      return write_column(hits, data, [](const Hit& h) { return std::array<float, 2>{h.u, h.v}; });
    case v1::HIT_FIELD_NORMAL:
      return write_column(hits, data, [](const Hit& h) { return h.normal; });
    case v1::HIT_FIELD_HIT:
      return write_column(hits, data, [](const Hit& h) { return h.state; });
    case v1::HIT_FIELD_WORK:
      return write_column(hits, data, [](const Hit& h) { return h.work; });
    default:
      return data.clear();  // decode_query lets no other field through
  }
}

constexpr std::uint8_t kCutOff = 3;

void write_tallies(std::span<const RayTally> tallies, std::span<const Hit> hits, v1::HitField field,
                   std::string& data) {
  std::uint32_t end = 0;
  switch (field) {
    case v1::HIT_FIELD_OFFSET:
      write_column(tallies, data, [&](const RayTally& r) { return end += r.count; });
      data.insert(0, sizeof(end), '\0');
      return;
    case v1::HIT_FIELD_COUNT:
      return write_column(tallies, data, [](const RayTally& r) { return r.count; });
    case v1::HIT_FIELD_HIT:
      return write_column(tallies, data, [](const RayTally& r) {
        return r.cut_off ? kCutOff : static_cast<std::uint8_t>(r.state);
      });
    case v1::HIT_FIELD_WORK:
      return write_column(tallies, data, [](const RayTally& r) { return r.work; });
    default:
      return write_hits(hits, field, data);
  }
}

/// write(field, data) fills the column of each field. What the reply held before is overwritten.
template <class Write>
void write_columns(std::span<const v1::HitField> fields, v1::CastRaysResponse& reply,
                   const Write& write) {
  const auto count = static_cast<int>(fields.size());
  while (reply.columns_size() > count) reply.mutable_columns()->RemoveLast();
  while (reply.columns_size() < count) reply.add_columns();
  for (int i = 0; i < count; ++i) {
    v1::HitColumn& column = *reply.mutable_columns(i);
    column.set_field(fields[static_cast<std::size_t>(i)]);
    write(column.field(), *column.mutable_data());
  }
}

static_assert(sizeof(accel::geometry::Vec3f) == 3 * sizeof(float) &&
              sizeof(accel::geometry::HitState) == 1);

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
  if (count > kMaxRaysPerRequest) {
    return Error{
        Code::kResourceExhausted,
        fmt::format(
            "the request has {} rays, the limit is {}; send more requests or use StreamCastRays",
            count, kMaxRaysPerRequest),
        "TOO_MANY_RAYS"};
  }
  if (const Status good = check_columns(columns, count, element); !good) return good.error();
  return count;
}

Status decode_rays(const v1::Rays& columns, std::vector<Ray>& rays) {
  const auto count = count_rays(columns);
  if (!count) return count.error();
  rays.assign(*count, Ray{});
  if (columns.float64()) {
    fill<double>(columns, rays);
  } else {
    fill<float>(columns, rays);
  }
  return {};
}

void encode_hits(std::span<const Hit> hits, std::span<const v1::HitField> fields,
                 v1::CastRaysResponse& reply) {
  write_columns(fields, reply,
                [&](v1::HitField field, std::string& data) { write_hits(hits, field, data); });
}

void encode_tallies(std::span<const RayTally> tallies, std::span<const Hit> hits,
                    std::span<const v1::HitField> fields, v1::CastRaysResponse& reply) {
  write_columns(fields, reply, [&](v1::HitField field, std::string& data) {
    write_tallies(tallies, hits, field, data);
  });
}

void encode_stats(const scenegraph::TraceStats& stats, v1::CastStats& reply) {
  reply.set_rays(stats.rays);
  reply.set_hits(stats.hits);
  reply.set_invalid(stats.invalid);
  reply.set_hits_found(stats.hits_found);
  reply.set_rays_cut_off(stats.cut_off);
  reply.set_traversal_steps(stats.traversal_steps);
  reply.set_triangle_tests(stats.triangle_tests);
  reply.set_instances_entered(stats.instances_entered);
  reply.set_cells_expanded(stats.cells_expanded);
  reply.set_build_us(static_cast<std::uint64_t>(stats.build_seconds * 1e6));
}

}  // namespace sightline::server::queries
