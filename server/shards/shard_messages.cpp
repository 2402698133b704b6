// Encodes questions to shards, and decodes their answers.
#include "server/shards/shard_messages.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

namespace sightline::server::shards {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using scenegraph::QueryKind;
using scenegraph::RayTally;
using scenegraph::Side;
using scenegraph::query::ShardQuestion;

/// The HIT of a ray with more hits than max_hits.
constexpr std::uint8_t kCutOff = 3;

v1::QueryKind encode(QueryKind kind) {
  switch (kind) {
    case QueryKind::kClosest:
      break;
    case QueryKind::kAny:
      return v1::QUERY_KIND_ANY;
    case QueryKind::kCount:
      return v1::QUERY_KIND_COUNT;
    case QueryKind::kAll:
      return v1::QUERY_KIND_ALL;
  }
  return v1::QUERY_KIND_CLOSEST;
}

std::vector<v1::HitField> fields_of(QueryKind kind, bool surface) {
  std::vector<v1::HitField> fields{v1::HIT_FIELD_HIT, v1::HIT_FIELD_WORK};
  if (kind == QueryKind::kCount) fields.push_back(v1::HIT_FIELD_COUNT);
  if (kind == QueryKind::kAny || kind == QueryKind::kCount) return fields;
  for (const v1::HitField field : {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE})
    fields.push_back(field);
  if (!surface) return fields;
  fields.push_back(v1::HIT_FIELD_BARYCENTRIC);
  fields.push_back(v1::HIT_FIELD_NORMAL);
  return fields;
}

template <class T>
void append(std::string& column, const T& value) {
  column.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

/// The columns of a reply; an error if one that is needed has not the bytes that it must have.
class Columns {
 public:
  explicit Columns(const HitColumns& columns) : columns_(columns) {}

  /// Calls set(row, value) for each row. A column that is not there is left out, unless `needed`.
  template <class T, class Set>
  void read(v1::HitField field, std::size_t rows, bool needed, const Set& set) {
    const std::string* data = nullptr;
    for (const v1::HitColumn& column : columns_) {
      if (column.field() == field) data = &column.data();
    }
    if (data == nullptr && !needed) return;
    if (data == nullptr || data->size() != rows * sizeof(T)) {
      wrong_ = Error{Code::kInternal,
                     fmt::format("a shard's answer has {} bytes of {}, expected {}",
                                 data == nullptr ? 0 : data->size(), v1::HitField_Name(field),
                                 rows * sizeof(T)),
                     "SHARD_ANSWER"};
      return;
    }
    for (std::size_t i = 0; i < rows; ++i) {
      T value;
      std::memcpy(&value, data->data() + i * sizeof(T), sizeof(T));
      set(i, value);
    }
  }
  void fail(const char* why) { wrong_ = Error{Code::kInternal, why, "SHARD_ANSWER"}; }
  const std::optional<Error>& wrong() const { return wrong_; }

 private:
  const HitColumns& columns_;
  std::optional<Error> wrong_;
};

void read_hits(Columns& columns, std::vector<Hit>& hits) {
  const std::size_t rows = hits.size();
  columns.read<double>(v1::HIT_FIELD_T, rows, true, [&](auto i, double t) { hits[i].t = t; });
  columns.read<std::uint64_t>(v1::HIT_FIELD_NODE, rows, true,
                              [&](auto i, std::uint64_t node) { hits[i].node = node; });
  columns.read<std::uint32_t>(v1::HIT_FIELD_PRIMITIVE, rows, true,
                              [&](auto i, std::uint32_t face) { hits[i].primitive = face; });
  columns.read<std::array<float, 2>>(v1::HIT_FIELD_BARYCENTRIC, rows, false,
                                     [&](auto i, const std::array<float, 2>& weights) {
                                       hits[i].u = weights[0];
                                       hits[i].v = weights[1];
                                     });
  columns.read<accel::geometry::Vec3f>(
      v1::HIT_FIELD_NORMAL, rows, false,
      [&](auto i, const accel::geometry::Vec3f& normal) { hits[i].normal = normal; });
}

/// Reads the states and the work of rays or of tallies.
template <class Row>
void read_states(Columns& columns, std::vector<Row>& rows) {
  columns.read<std::uint8_t>(v1::HIT_FIELD_HIT, rows.size(), true, [&](auto i, std::uint8_t hit) {
    rows[i].state = hit == kCutOff ? HitState::kHit : static_cast<HitState>(hit);
    if constexpr (std::is_same_v<Row, RayTally>) rows[i].cut_off = hit == kCutOff;
  });
  columns.read<std::uint32_t>(v1::HIT_FIELD_WORK, rows.size(), true,
                              [&](auto i, std::uint32_t work) { rows[i].work = work; });
}

/// Sets the counts, and returns their sum.
std::size_t read_offsets(Columns& columns, std::vector<RayTally>& tallies) {
  std::uint32_t before = 0;
  bool ascending = true;
  columns.read<std::uint32_t>(v1::HIT_FIELD_OFFSET, tallies.size() + 1, true,
                              [&](std::size_t i, std::uint32_t offset) {
                                ascending &= offset >= before && (i > 0 || offset == 0);
                                if (i > 0) tallies[i - 1].count = offset - before;
                                before = offset;
                              });
  if (!ascending) columns.fail("the offsets in a shard's answer do not ascend from 0");
  return before;
}

template <class Request>
Request template_of(const Request& asked, QueryKind kind, const std::vector<v1::HitField>& fields) {
  Request request;
  request.set_scene(asked.scene());
  request.set_kind(encode(kind));
  for (const v1::HitField field : fields) request.add_fields(field);
  request.set_build(asked.build());
  request.set_root(asked.root());
  *request.mutable_exclude() = asked.exclude();
  *request.mutable_only_labels() = asked.only_labels();
  *request.mutable_exclude_labels() = asked.exclude_labels();
  request.set_max_hits(asked.max_hits());
  return request;
}

}  // namespace

v1::CastRaysRequest make_template(const v1::CastRaysRequest& asked, QueryKind kind, bool surface) {
  v1::CastRaysRequest request = template_of(asked, kind, fields_of(kind, surface));
  request.set_culling(asked.culling());
  return request;
}

v1::QueryPointsRequest make_template(const v1::QueryPointsRequest& asked, QueryKind kind,
                                     bool surface) {
  return template_of(asked, kind, fields_of(kind, surface));
}

v1::QueryPointsRequest make_side_template(const v1::QueryPointsRequest& asked,
                                          const scenegraph::SideQuestion& sides) {
  std::vector<v1::HitField> fields{v1::HIT_FIELD_INSIDE};
  if (sides.rule != scenegraph::SideRule::kNormal) fields.push_back(v1::HIT_FIELD_CROSSINGS);
  v1::QueryPointsRequest request = template_of(asked, QueryKind::kClosest, fields);
  request.set_side_rule(asked.side_rule());
  request.set_side_rays(sides.rays);
  return request;
}

void set_rays(const RayOf& ray_of, const ShardQuestion& question, v1::QueryPointsRequest& request) {
  v1::Points& points = *request.mutable_points();
  points.set_float64(true);
  points.set_count(question.rays.size());
  const std::size_t reals = question.rays.size() * sizeof(double);
  points.mutable_positions()->reserve(3 * reals);
  points.mutable_max_distance()->reserve(reals);
  points.mutable_masks()->reserve(question.rays.size() * sizeof(std::uint32_t));
  for (const std::uint32_t i : question.rays) {
    const Ray ray = ray_of(i);
    append(*points.mutable_positions(), ray.origin);
    append(*points.mutable_max_distance(), ray.tmax);
    append(*points.mutable_masks(), ray.mask);
  }
}

void set_rays(const RayOf& ray_of, const ShardQuestion& question, v1::CastRaysRequest& request) {
  v1::Rays& rays = *request.mutable_rays();
  rays.set_float64(true);
  rays.set_count(question.rays.size());
  const std::size_t reals = question.rays.size() * sizeof(double);
  rays.mutable_origins()->reserve(3 * reals);
  rays.mutable_directions()->reserve(3 * reals);
  rays.mutable_tmin()->reserve(reals);
  rays.mutable_tmax()->reserve(reals);
  rays.mutable_masks()->reserve(question.rays.size() * sizeof(std::uint32_t));
  for (const std::uint32_t i : question.rays) {
    const Ray ray = ray_of(i);
    append(*rays.mutable_origins(), ray.origin);
    append(*rays.mutable_directions(), ray.direction);
    append(*rays.mutable_tmin(), ray.tmin);
    append(*rays.mutable_tmax(), ray.tmax);
    append(*rays.mutable_masks(), ray.mask);
  }
}

Result<ShardAnswer> decode(const HitColumns& of_reply, QueryKind kind, std::size_t rays) {
  ShardAnswer answer;
  Columns columns(of_reply);
  if (kind == QueryKind::kClosest || kind == QueryKind::kAny) {
    answer.hits.resize(rays);
    read_states(columns, answer.hits);
    if (kind == QueryKind::kClosest) read_hits(columns, answer.hits);
  } else {
    answer.tallies.resize(rays);
    read_states(columns, answer.tallies);
    if (kind == QueryKind::kCount) {
      columns.read<std::uint32_t>(
          v1::HIT_FIELD_COUNT, rays, true,
          [&](auto i, std::uint32_t count) { answer.tallies[i].count = count; });
    } else {
      // There are no more hits than the columns hold, whatever the offsets say.
      const std::size_t listed = read_offsets(columns, answer.tallies);
      columns.read<double>(v1::HIT_FIELD_T, listed, true, [](auto, double) {});
      if (!columns.wrong()) {
        answer.hits.resize(listed);
        for (Hit& hit : answer.hits) hit.state = HitState::kHit;
        read_hits(columns, answer.hits);
      }
    }
  }
  if (columns.wrong()) return *columns.wrong();
  return answer;
}

Result<ShardSideAnswer> decode_sides(const HitColumns& of_reply,
                                     const scenegraph::SideQuestion& question, std::size_t points) {
  ShardSideAnswer answer;
  Columns columns(of_reply);
  answer.sides.resize(points);
  bool known = true;
  columns.read<std::uint8_t>(v1::HIT_FIELD_INSIDE, points, true, [&](auto i, std::uint8_t side) {
    answer.sides[i] = static_cast<Side>(side);
    known &= answer.sides[i] == Side::kOutside || answer.sides[i] == Side::kInside ||
             answer.sides[i] == Side::kInvalid || answer.sides[i] == Side::kUnanswered;
  });
  if (!known) columns.fail("a shard's answer has sides that do not exist");
  if (question.rule != scenegraph::SideRule::kNormal) {
    answer.crossings.resize(points * question.rays);
    columns.read<std::uint32_t>(
        v1::HIT_FIELD_CROSSINGS, answer.crossings.size(), true,
        [&](auto i, std::uint32_t crossings) { answer.crossings[i] = crossings; });
  }
  if (columns.wrong()) return *columns.wrong();
  return answer;
}

scenegraph::TraceStats decode_cost(const v1::CastStats& stats) {
  scenegraph::TraceStats cost;
  cost.traversal_steps = stats.traversal_steps();
  cost.triangle_tests = stats.triangle_tests();
  cost.instances_entered = stats.instances_entered();
  cost.cells_expanded = stats.cells_expanded();
  cost.build_seconds = static_cast<double>(stats.build_us()) * 1e-6;
  return cost;
}

}  // namespace sightline::server::shards
