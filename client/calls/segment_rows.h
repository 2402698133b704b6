// The columns of rays, points and answers, as a segment has them. Internal to the library.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "client/calls/segment_columns.h"
#include "client/cast_options.h"
#include "client/points.h"
#include "client/ray_generator.h"
#include "sightline/v1/query.pb.h"

namespace sightline::client::calls {

namespace v1 = ::sightline::v1;

/// Calls f(column, field, width) for each column that has a row a ray, other than names. Hits are
/// HitColumns or HitView. The width of bits is 0.
template <class Hits, class Function>
void for_each_column(Hits& hits, const Function& f) {
  f(hits.t, v1::HIT_FIELD_T, 1);
  f(hits.node, v1::HIT_FIELD_NODE, 1);
  f(hits.primitive, v1::HIT_FIELD_PRIMITIVE, 1);
  f(hits.barycentric, v1::HIT_FIELD_BARYCENTRIC, 2);
  f(hits.normal, v1::HIT_FIELD_NORMAL, 3);
  f(hits.hit, v1::HIT_FIELD_HIT, 1);
  f(hits.work, v1::HIT_FIELD_WORK, 1);
  f(hits.count, v1::HIT_FIELD_COUNT, 1);
  f(hits.hit_bits, v1::HIT_FIELD_HIT_BITS, 0);
  f(hits.position, v1::HIT_FIELD_POSITION, 3);
  f(hits.signed_distance, v1::HIT_FIELD_SIGNED, 1);
  f(hits.inside, v1::HIT_FIELD_INSIDE, 1);
  f(hits.votes, v1::HIT_FIELD_VOTES, 1);
}

/// The columns of rows, in the order of set_rows(). Generators have none.
template <class Scalar>
std::vector<ColumnBytes> columns_of(const RayColumns<const Scalar>& rays);
template <class Scalar>
std::vector<ColumnBytes> columns_of(const PointColumns<const Scalar>& points);
inline std::vector<ColumnBytes> columns_of(const RayGenerator&) { return {}; }
inline std::vector<ColumnBytes> columns_of(const PointGrid&) { return {}; }

/// The columns of answers: those of for_each_column(), then names.
std::vector<ColumnBytes> columns_of(const HitColumns& hits);

std::uint64_t row_count(const RayGenerator& generator);
std::uint64_t row_count(const PointGrid& grid);
template <class Columns>
std::uint64_t row_count(const Columns& rows) {
  return rows.size();
}

/// Sets `count` rows from `first` on. The columns begin with those of the rows.
template <class Scalar>
void set_rows(const RayColumns<const Scalar>& rays, const SegmentColumns& columns,
              std::uint64_t message, std::uint64_t first, std::uint64_t count,
              v1::CastRaysRequest& request);
template <class Scalar>
void set_rows(const PointColumns<const Scalar>& points, const SegmentColumns& columns,
              std::uint64_t message, std::uint64_t first, std::uint64_t count,
              v1::QueryPointsRequest& request);
void set_rows(const RayGenerator& generator, const SegmentColumns& columns, std::uint64_t message,
              std::uint64_t first, std::uint64_t count, v1::CastRaysRequest& request);
void set_rows(const PointGrid& grid, const SegmentColumns& columns, std::uint64_t message,
              std::uint64_t first, std::uint64_t count, v1::QueryPointsRequest& request);

/// The rows from `first` on.
template <class Scalar>
RayColumns<const Scalar> rest_of(const RayColumns<const Scalar>& rays, std::uint64_t first);
template <class Scalar>
PointColumns<const Scalar> rest_of(const PointColumns<const Scalar>& points, std::uint64_t first);
RayGenerator rest_of(RayGenerator generator, std::uint64_t first);
PointGrid rest_of(PointGrid grid, std::uint64_t first);

}  // namespace sightline::client::calls
