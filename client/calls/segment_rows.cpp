// Arrays as bytes, and offsets in messages.
#include "client/calls/segment_rows.h"

#include <cstddef>

#include "client/wire/generator_codec.h"

namespace sightline::client::calls {
namespace {

template <class T>
ColumnBytes column_of(std::span<T> values, std::size_t width, bool is_answer = false) {
  if (values.empty()) return {};
  using Value = std::remove_const_t<T>;
  auto* const data = reinterpret_cast<std::byte*>(const_cast<Value*>(values.data()));
  return {data, width == 0 ? 1 : 8 * width * sizeof(T), is_answer};
}

template <class T>
std::span<T> rest(std::span<T> column, std::size_t width, std::uint64_t first) {
  return column.empty() ? column : column.subspan(first * width);
}

template <class Generator>
Generator rest_of_generator(Generator generator, std::uint64_t first) {
  const std::uint64_t count = proto::rays::count_of(generator);
  generator.first += first;
  generator.count = count - first;
  return generator;
}

// The message is encoded once; later messages of the stream have other rows of it.
template <class Generator, class Message>
void set_part(const Generator& generator, bool is_set, std::uint64_t first, std::uint64_t count,
              Message& message) {
  if (!is_set) wire::encode(generator, message);
  message.set_first(generator.first + first);
  message.set_count(count);
}

}  // namespace

template <class Scalar>
std::vector<ColumnBytes> columns_of(const RayColumns<const Scalar>& rays) {
  return {column_of(rays.origins, 3), column_of(rays.directions, 3), column_of(rays.tmin, 1),
          column_of(rays.tmax, 1), column_of(rays.masks, 1)};
}

template <class Scalar>
std::vector<ColumnBytes> columns_of(const PointColumns<const Scalar>& points) {
  return {column_of(points.positions, 3), column_of(points.max_distance, 1),
          column_of(points.masks, 1)};
}

std::vector<ColumnBytes> columns_of(const HitColumns& hits) {
  std::vector<ColumnBytes> columns;
  for_each_column(hits, [&](const auto& column, v1::HitField, std::size_t width) {
    columns.push_back(column_of(column, width, true));
  });
  ColumnBytes names;
  if (!hits.name.empty()) names = {nullptr, 8 * sizeof(std::uint32_t), true};
  columns.push_back(names);
  return columns;
}

std::uint64_t row_count(const RayGenerator& generator) { return proto::rays::count_of(generator); }
std::uint64_t row_count(const PointGrid& grid) { return proto::rays::count_of(grid); }

template <class Scalar>
void set_rows(const RayColumns<const Scalar>&, const SegmentColumns& columns, std::uint64_t message,
              std::uint64_t first, std::uint64_t count, v1::CastRaysRequest& request) {
  columns.copy_rows(message, first, count);
  v1::SharedRays& shared = *request.mutable_shared();
  shared.set_float64(std::is_same_v<Scalar, double>);
  shared.set_count(count);
  shared.set_origins(columns.offset(0, message, first));
  shared.set_directions(columns.offset(1, message, first));
  if (columns.exists(2)) shared.set_tmin(columns.offset(2, message, first));
  if (columns.exists(3)) shared.set_tmax(columns.offset(3, message, first));
  if (columns.exists(4)) shared.set_masks(columns.offset(4, message, first));
}

template <class Scalar>
void set_rows(const PointColumns<const Scalar>&, const SegmentColumns& columns,
              std::uint64_t message, std::uint64_t first, std::uint64_t count,
              v1::QueryPointsRequest& request) {
  columns.copy_rows(message, first, count);
  v1::SharedPoints& shared = *request.mutable_shared();
  shared.set_float64(std::is_same_v<Scalar, double>);
  shared.set_count(count);
  shared.set_positions(columns.offset(0, message, first));
  if (columns.exists(1)) shared.set_max_distance(columns.offset(1, message, first));
  if (columns.exists(2)) shared.set_masks(columns.offset(2, message, first));
}

void set_rows(const RayGenerator& generator, const SegmentColumns&, std::uint64_t,
              std::uint64_t first, std::uint64_t count, v1::CastRaysRequest& request) {
  const bool is_set = request.has_generator();
  set_part(generator, is_set, first, count, *request.mutable_generator());
}

void set_rows(const PointGrid& grid, const SegmentColumns&, std::uint64_t, std::uint64_t first,
              std::uint64_t count, v1::QueryPointsRequest& request) {
  const bool is_set = request.has_grid();
  set_part(grid, is_set, first, count, *request.mutable_grid());
}

template <class Scalar>
RayColumns<const Scalar> rest_of(const RayColumns<const Scalar>& rays, std::uint64_t first) {
  return {rest(rays.origins, 3, first), rest(rays.directions, 3, first), rest(rays.tmin, 1, first),
          rest(rays.tmax, 1, first), rest(rays.masks, 1, first)};
}

template <class Scalar>
PointColumns<const Scalar> rest_of(const PointColumns<const Scalar>& points, std::uint64_t first) {
  return {rest(points.positions, 3, first), rest(points.max_distance, 1, first),
          rest(points.masks, 1, first)};
}

RayGenerator rest_of(RayGenerator generator, std::uint64_t first) {
  return rest_of_generator(std::move(generator), first);
}
PointGrid rest_of(PointGrid grid, std::uint64_t first) { return rest_of_generator(grid, first); }

template std::vector<ColumnBytes> columns_of(const RayColumns<const float>&);
template std::vector<ColumnBytes> columns_of(const RayColumns<const double>&);
template std::vector<ColumnBytes> columns_of(const PointColumns<const float>&);
template std::vector<ColumnBytes> columns_of(const PointColumns<const double>&);
template void set_rows(const RayColumns<const float>&, const SegmentColumns&, std::uint64_t,
                       std::uint64_t, std::uint64_t, v1::CastRaysRequest&);
template void set_rows(const RayColumns<const double>&, const SegmentColumns&, std::uint64_t,
                       std::uint64_t, std::uint64_t, v1::CastRaysRequest&);
template void set_rows(const PointColumns<const float>&, const SegmentColumns&, std::uint64_t,
                       std::uint64_t, std::uint64_t, v1::QueryPointsRequest&);
template void set_rows(const PointColumns<const double>&, const SegmentColumns&, std::uint64_t,
                       std::uint64_t, std::uint64_t, v1::QueryPointsRequest&);
template RayColumns<const float> rest_of(const RayColumns<const float>&, std::uint64_t);
template RayColumns<const double> rest_of(const RayColumns<const double>&, std::uint64_t);
template PointColumns<const float> rest_of(const PointColumns<const float>&, std::uint64_t);
template PointColumns<const double> rest_of(const PointColumns<const double>&, std::uint64_t);

}  // namespace sightline::client::calls
