// Columns of messages are the bytes of the arrays.
#include "client/wire/cast_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "client/wire/option_codec.h"
#include "client/wire/scene_codec.h"

namespace sightline::client::wire {
namespace {

template <class T>
std::span<T> resize(std::size_t rows, std::size_t width, std::string& column) {
  column.resize(rows * width * sizeof(T));
  return {reinterpret_cast<T*>(column.data()), rows * width};
}

std::uint64_t first_row(const v1::CastRaysResponse& response) { return response.first_ray(); }
std::uint64_t first_row(const v1::QueryPointsResponse& response) { return response.first_point(); }

constexpr const char* rows_of(const v1::CastRaysResponse&) { return "rays"; }
constexpr const char* rows_of(const v1::QueryPointsResponse&) { return "points"; }

// The options that only one of the two has.
void set_own(const CastOptions& options, v1::CastRaysRequest& request) {
  request.set_culling(encode(options.culling));
}
void set_own(const CastOptions& options, v1::QueryPointsRequest& request) {
  if (options.side_rule) request.set_side_rule(encode(*options.side_rule));
  request.set_side_rays(options.side_rays);
}

template <class Response>
const std::string* find(const Response& response, v1::HitField field) {
  for (const v1::HitColumn& column : response.columns()) {
    if (column.field() == field) return &column.data();
  }
  return nullptr;
}

template <class Response>
Error incomplete(const Response& response, std::size_t n) {
  return {Code::kInternal,
          fmt::format("the server's answer to {} {} lacks a column, or rows of one", n,
                      rows_of(response)),
          {}};
}

// Sets `out` to a column if it was requested. Returns false if the answer does not have it with n
// rows.
template <class T, class Response>
bool view_column(const Response& response, bool asked, v1::HitField field, std::size_t values,
                 std::span<const T>& out) {
  if (!asked) return true;
  const std::string* data = find(response, field);
  if (data == nullptr || data->size() != values * sizeof(T)) return false;
  out = {reinterpret_cast<const T*>(data->data()), values};
  return true;
}

template <class Response>
bool view_unanswered(const Response& response, std::size_t n, HitView& hits) {
  const std::string& bits = response.unanswered();
  hits.unanswered = {reinterpret_cast<const std::uint8_t*>(bits.data()), bits.size()};
  return bits.empty() || bits.size() == bits_bytes(n);
}

template <class Response>
bool view_sides(const Response& response, HitFields fields, std::size_t n, HitView& hits) {
  return view_column(response, fields.signed_distance, v1::HIT_FIELD_SIGNED, n,
                     hits.signed_distance) &&
         view_column(response, fields.inside, v1::HIT_FIELD_INSIDE, n, hits.inside) &&
         view_column(response, fields.votes, v1::HIT_FIELD_VOTES, n, hits.votes);
}

template <class Response>
bool view_rays(const Response& response, HitFields fields, std::size_t n, HitView& hits) {
  return view_unanswered(response, n, hits) &&
         view_column(response, fields.hit, v1::HIT_FIELD_HIT, n, hits.hit) &&
         view_column(response, fields.hit_bits, v1::HIT_FIELD_HIT_BITS, bits_bytes(n),
                     hits.hit_bits) &&
         view_column(response, fields.work, v1::HIT_FIELD_WORK, n, hits.work) &&
         view_column(response, fields.count, v1::HIT_FIELD_COUNT, n, hits.count) &&
         view_sides(response, fields, n, hits);
}

// Views the names. Returns false if a row is not one of them.
template <class Response>
bool view_names_of_rows(const Response& response, HitView& hits) {
  hits.names.assign(response.names().begin(), response.names().end());
  return std::all_of(hits.name.begin(), hits.name.end(),
                     [&](std::uint32_t row) { return row < hits.names.size(); });
}

template <class Response>
bool view_names(const Response& response, HitFields fields, std::size_t n, HitView& hits) {
  return !fields.name || (view_column(response, true, v1::HIT_FIELD_NAME, n, hits.name) &&
                          view_names_of_rows(response, hits));
}

template <class Response>
bool view_surfaces(const Response& response, HitFields fields, std::size_t n, HitView& hits) {
  return view_column(response, fields.t, v1::HIT_FIELD_T, n, hits.t) &&
         view_column(response, fields.node, v1::HIT_FIELD_NODE, n, hits.node) &&
         view_column(response, fields.primitive, v1::HIT_FIELD_PRIMITIVE, n, hits.primitive) &&
         view_column(response, fields.barycentric, v1::HIT_FIELD_BARYCENTRIC, 2 * n,
                     hits.barycentric) &&
         view_column(response, fields.normal, v1::HIT_FIELD_NORMAL, 3 * n, hits.normal) &&
         view_column(response, fields.position, v1::HIT_FIELD_POSITION, 3 * n, hits.position) &&
         view_names(response, fields, n, hits);
}

}  // namespace

std::uint32_t milliseconds_of(std::chrono::milliseconds budget) {
  if (budget.count() == 0) return 0;
  constexpr std::int64_t kMost = std::numeric_limits<std::uint32_t>::max();
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(budget.count(), 1, kMost));
}

template <class Request>
void describe(const std::string& scene, HitFields fields, const CastOptions& options,
              Request& request) {
  request.set_scene(scene);
  request.set_kind(encode(options.kind));
  request.set_build(encode(options.build));
  set_own(options, request);
  request.set_root(options.root);
  request.mutable_exclude()->Assign(options.exclude.begin(), options.exclude.end());
  encode(options.only_labels, *request.mutable_only_labels());
  encode(options.exclude_labels, *request.mutable_exclude_labels());
  request.set_max_hits(options.max_hits);
  request.set_time_budget_ms(milliseconds_of(options.time_budget));
  request.set_allow_partial(options.allow_partial);
  *request.mutable_consistency() = encode(options.consistency);
  // Without any field the server would send its default fields.
  if (options.kind == QueryKind::kAll) fields.hit = true;
  if (fields.t) request.add_fields(v1::HIT_FIELD_T);
  if (fields.node) request.add_fields(v1::HIT_FIELD_NODE);
  if (fields.primitive) request.add_fields(v1::HIT_FIELD_PRIMITIVE);
  if (fields.barycentric) request.add_fields(v1::HIT_FIELD_BARYCENTRIC);
  if (fields.normal) request.add_fields(v1::HIT_FIELD_NORMAL);
  if (fields.hit) request.add_fields(v1::HIT_FIELD_HIT);
  if (fields.hit_bits) request.add_fields(v1::HIT_FIELD_HIT_BITS);
  if (fields.work) request.add_fields(v1::HIT_FIELD_WORK);
  if (fields.count) request.add_fields(v1::HIT_FIELD_COUNT);
  if (fields.position) request.add_fields(v1::HIT_FIELD_POSITION);
  if (fields.name) request.add_fields(v1::HIT_FIELD_NAME);
  if (fields.signed_distance) request.add_fields(v1::HIT_FIELD_SIGNED);
  if (fields.inside) request.add_fields(v1::HIT_FIELD_INSIDE);
  if (fields.votes) request.add_fields(v1::HIT_FIELD_VOTES);
}

template <class Scalar>
RayColumns<Scalar> resize_columns(std::size_t n, RayShape shape, v1::Rays& rays) {
  rays.set_float64(std::is_same_v<Scalar, double>);
  rays.set_count(n);
  RayColumns<Scalar> columns;
  columns.origins = resize<Scalar>(n, 3, *rays.mutable_origins());
  columns.directions = resize<Scalar>(n, 3, *rays.mutable_directions());
  if (shape.interval) {
    columns.tmin = resize<Scalar>(n, 1, *rays.mutable_tmin());
    columns.tmax = resize<Scalar>(n, 1, *rays.mutable_tmax());
  }
  if (shape.masks) columns.masks = resize<std::uint32_t>(n, 1, *rays.mutable_masks());
  return columns;
}

template <class Scalar>
PointColumns<Scalar> resize_columns(std::size_t n, PointShape shape, v1::Points& points) {
  points.set_float64(std::is_same_v<Scalar, double>);
  points.set_count(n);
  PointColumns<Scalar> columns;
  columns.positions = resize<Scalar>(n, 3, *points.mutable_positions());
  if (shape.max_distance)
    columns.max_distance = resize<Scalar>(n, 1, *points.mutable_max_distance());
  if (shape.masks) columns.masks = resize<std::uint32_t>(n, 1, *points.mutable_masks());
  return columns;
}

template <class Response>
Result<HitView> view_hits(const Response& response, HitFields fields, std::size_t n) {
  HitView hits;
  if (!view_rays(response, fields, n, hits) || !view_surfaces(response, fields, n, hits))
    return incomplete(response, n);
  return hits;
}

template <class Response>
Status complete_view(const Response& response, bool has_names, std::size_t n, HitView& hits) {
  if (!view_unanswered(response, n, hits) || (has_names && !view_names_of_rows(response, hits)))
    return incomplete(response, n);
  return {};
}

template <class Response>
Result<HitView> view_all_hits(const Response& response, HitFields fields, std::size_t first,
                              std::size_t n) {
  HitView hits;
  const std::string* column = find(response, v1::HIT_FIELD_OFFSET);
  const std::size_t rays = column == nullptr ? 0 : column->size() / sizeof(std::uint32_t) - 1;
  if (rays > n || !view_column(response, true, v1::HIT_FIELD_OFFSET, rays + 1, hits.offsets))
    return incomplete(response, n);
  const bool continues_the_batch =
      first_row(response) == first && rays <= n - first && response.more() == (first + rays < n) &&
      hits.offsets.front() == 0 && std::is_sorted(hits.offsets.begin(), hits.offsets.end());
  if (!continues_the_batch) {
    return Error{Code::kInternal,
                 fmt::format("the server answered {} {} from {} on, instead of from {} to {}", rays,
                             rows_of(response), first_row(response), first, n),
                 {}};
  }
  fields.hit = true;
  if (!view_rays(response, fields, rays, hits) ||
      !view_surfaces(response, fields, hits.offsets.back(), hits))
    return incomplete(response, n);
  return hits;
}

template <class Response>
void add_stats(const Response& response, CastReport& report) {
  const v1::CastStats& stats = response.stats();
  report.revision = response.served().revision();
  report.token = response.served().token();
  report.rays += stats.rays();
  report.hits += stats.hits();
  report.invalid += stats.invalid();
  report.unanswered += stats.unanswered();
  report.hits_found += stats.hits_found();
  report.rays_cut_off += stats.rays_cut_off();
  report.traversal_steps += stats.traversal_steps();
  report.triangle_tests += stats.triangle_tests();
  report.instances_entered += stats.instances_entered();
  report.cells_expanded += stats.cells_expanded();
  report.queue_us += stats.queue_us();
  report.build_us += stats.build_us();
  report.trace_us += stats.trace_us();
}

template void describe(const std::string&, HitFields, const CastOptions&, v1::CastRaysRequest&);
template void describe(const std::string&, HitFields, const CastOptions&, v1::QueryPointsRequest&);
template RayColumns<float> resize_columns(std::size_t, RayShape, v1::Rays&);
template RayColumns<double> resize_columns(std::size_t, RayShape, v1::Rays&);
template PointColumns<float> resize_columns(std::size_t, PointShape, v1::Points&);
template PointColumns<double> resize_columns(std::size_t, PointShape, v1::Points&);
template Result<HitView> view_hits(const v1::CastRaysResponse&, HitFields, std::size_t);
template Result<HitView> view_hits(const v1::QueryPointsResponse&, HitFields, std::size_t);
template Status complete_view(const v1::CastRaysResponse&, bool, std::size_t, HitView&);
template Status complete_view(const v1::QueryPointsResponse&, bool, std::size_t, HitView&);
template Result<HitView> view_all_hits(const v1::CastRaysResponse&, HitFields, std::size_t,
                                       std::size_t);
template Result<HitView> view_all_hits(const v1::QueryPointsResponse&, HitFields, std::size_t,
                                       std::size_t);
template void add_stats(const v1::CastRaysResponse&, CastReport&);
template void add_stats(const v1::QueryPointsResponse&, CastReport&);

}  // namespace sightline::client::wire
