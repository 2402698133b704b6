// Ray batches between the wire and the tracer.
#include "server/codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

namespace sightline::server {
namespace {

static_assert(std::endian::native == std::endian::little,
              "columns are little-endian and are copied as they are");

using accel::Hit;
using accel::Ray;
using scenegraph::Growth;
using scenegraph::QueryKind;

Error invalid(std::string message, std::string reason) {
  return {Code::kInvalidArgument, std::move(message), std::move(reason)};
}

template <class T>
T load(const std::string& column, std::size_t index) {
  T value;
  std::memcpy(&value, column.data() + index * sizeof(T), sizeof(T));
  return value;
}

template <class T>
accel::Vec3d load_vector(const std::string& column, std::size_t row) {
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
  return invalid(
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

Result<QueryKind> decode_kind(v1::QueryKind kind) {
  switch (kind) {
    case v1::QUERY_KIND_UNSPECIFIED:
    case v1::QUERY_KIND_CLOSEST:
      return QueryKind::kClosest;
    case v1::QUERY_KIND_ANY:
      return QueryKind::kAny;
    default:
      return invalid(fmt::format("query kind {} is not known", static_cast<int>(kind)),
                     "UNKNOWN_KIND");
  }
}

Result<Growth> decode_growth(v1::BuildMode build, Growth policy) {
  switch (build) {
    case v1::BUILD_MODE_UNSPECIFIED:
      return policy;
    case v1::BUILD_MODE_LAZY:
      return Growth::kFirstTouch;
    case v1::BUILD_MODE_FULL:
      return Growth::kFull;
    case v1::BUILD_MODE_NONE:
      return Growth::kNone;
    case v1::BUILD_MODE_BUILT_ONLY:
      return Growth::kBuiltOnly;
    default:
      return invalid(fmt::format("build mode {} is not known", static_cast<int>(build)),
                     "UNKNOWN_BUILD_MODE");
  }
}

Status check_field(v1::HitField field, QueryKind kind, std::span<const v1::HitField> before) {
  if (!v1::HitField_IsValid(field) || field == v1::HIT_FIELD_UNSPECIFIED) {
    return invalid(fmt::format("hit field {} is not known", static_cast<int>(field)),
                   "UNKNOWN_FIELD");
  }
  if (std::find(before.begin(), before.end(), field) != before.end()) {
    return invalid(fmt::format("{} is asked for twice", v1::HitField_Name(field)), "FIELD_TWICE");
  }
  if (kind == QueryKind::kAny && field != v1::HIT_FIELD_HIT && field != v1::HIT_FIELD_WORK) {
    return invalid(fmt::format("QUERY_KIND_ANY has HIT_FIELD_HIT and HIT_FIELD_WORK, not {}",
                               v1::HitField_Name(field)),
                   "FIELD_NOT_OF_KIND");
  }
  return {};
}

/// One column: `element(hit)` for every hit, each copied as its bytes.
template <class Element>
void write_column(std::span<const Hit> hits, std::string& data, Element element) {
  using Value = decltype(element(hits[0]));
  static_assert(std::is_trivially_copyable_v<Value>);
  data.resize(hits.size() * sizeof(Value));
  char* out = data.data();
  for (const Hit& hit : hits) {
    const Value value = element(hit);
    std::memcpy(out, &value, sizeof(Value));
    out += sizeof(Value);
  }
}

void write_field(std::span<const Hit> hits, v1::HitField field, std::string& data) {
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

static_assert(sizeof(accel::Vec3f) == 3 * sizeof(float) && sizeof(accel::HitState) == 1);

}  // namespace

Result<CastQuery> decode_query(const v1::CastRaysRequest& request, Growth policy) {
  const auto kind = decode_kind(request.kind());
  if (!kind) return kind.error();
  const auto growth = decode_growth(request.build(), policy);
  if (!growth) return growth.error();
  CastQuery query{*kind, *growth, {}, false};
  for (const int number : request.fields()) {
    const auto field = static_cast<v1::HitField>(number);
    if (const Status good = check_field(field, *kind, query.fields); !good) return good.error();
    query.fields.push_back(field);
    query.surface |= field == v1::HIT_FIELD_BARYCENTRIC || field == v1::HIT_FIELD_NORMAL;
  }
  if (*kind == QueryKind::kAny) {
    const bool has_hit = std::find(query.fields.begin(), query.fields.end(), v1::HIT_FIELD_HIT) !=
                         query.fields.end();
    if (!has_hit) query.fields.insert(query.fields.begin(), v1::HIT_FIELD_HIT);
  } else if (query.fields.empty()) {
    query.fields = {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE};
  }
  return query;
}

Status decode_rays(const v1::Rays& columns, std::vector<Ray>& rays) {
  const std::size_t element = columns.float64() ? sizeof(double) : sizeof(float);
  const std::size_t count = columns.origins().size() / (3 * element);
  if (columns.origins().size() % (3 * element) != 0) {
    return invalid(
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
  if (Status good = check_columns(columns, count, element); !good) return good;
  rays.assign(count, Ray{});
  if (columns.float64()) {
    fill<double>(columns, rays);
  } else {
    fill<float>(columns, rays);
  }
  return {};
}

void encode_hits(std::span<const Hit> hits, std::span<const v1::HitField> fields,
                 v1::CastRaysResponse& reply) {
  const auto count = static_cast<int>(fields.size());
  while (reply.columns_size() > count) reply.mutable_columns()->RemoveLast();
  while (reply.columns_size() < count) reply.add_columns();
  for (int i = 0; i < count; ++i) {
    v1::HitColumn& column = *reply.mutable_columns(i);
    column.set_field(fields[static_cast<std::size_t>(i)]);
    write_field(hits, column.field(), *column.mutable_data());
  }
}

void encode_stats(const scenegraph::TraceStats& stats, v1::CastStats& reply) {
  reply.set_rays(stats.rays);
  reply.set_hits(stats.hits);
  reply.set_invalid(stats.invalid);
  reply.set_traversal_steps(stats.traversal_steps);
  reply.set_triangle_tests(stats.triangle_tests);
  reply.set_instances_entered(stats.instances_entered);
  reply.set_cells_expanded(stats.cells_expanded);
  reply.set_build_us(static_cast<std::uint64_t>(stats.build_seconds * 1e6));
}

}  // namespace sightline::server
