// Copies between the columns of a caller and those of a message. Internal to the library.
#pragma once

#include <cstddef>
#include <cstdint>

#include "client/cast_options.h"
#include "client/points.h"
#include "client/result.h"

namespace sightline::client::calls {

template <class Scalar>
RayShape shape_of(const RayColumns<const Scalar>& rays) {
  return {!rays.tmin.empty() || !rays.tmax.empty(), !rays.masks.empty()};
}
template <class Scalar>
PointShape shape_of(const PointColumns<const Scalar>& points) {
  return {!points.max_distance.empty(), !points.masks.empty()};
}

/// The fields of the columns that are not empty.
HitFields fields_of(const HitColumns& hits);

/// Errors: kInvalidArgument for kAll, because its answers do not have one row per ray.
Status check_kind(QueryKind kind);

/// Errors: kInvalidArgument, naming the column, if a column does not have one row for each of the
/// `count` rays or points. `rows` is what the message calls them.
Status check_rows(std::size_t count, const HitColumns& hits, const char* rows = "rays");
template <class Scalar>
Status check_rows(const RayColumns<const Scalar>& rays, const HitColumns& hits);
template <class Scalar>
Status check_rows(const PointColumns<const Scalar>& points, const HitColumns& hits);

/// Fills all of `buffer`, beginning with row `first`.
template <class Scalar>
void copy_part(const RayColumns<const Scalar>& rays, std::size_t first,
               const RayColumns<Scalar>& buffer);
template <class Scalar>
void copy_part(const PointColumns<const Scalar>& points, std::size_t first,
               const PointColumns<Scalar>& buffer);

/// A source that gives the rows message by message. The columns must outlive it.
template <class Scalar>
RaySource<Scalar> source_of(const RayColumns<const Scalar>& rays);
template <class Scalar>
PointSource<Scalar> source_of(const PointColumns<const Scalar>& points);

/// Copies the answers into the columns, beginning at row `first`: a multiple of 8 if there are
/// bits.
void copy_hits(const HitView& answers, std::size_t first, const HitColumns& hits);

/// Clears `unanswered`, and returns a sink that copies answers into the columns, which must outlive
/// it.
HitSink copy_to(const HitColumns& hits);

}  // namespace sightline::client::calls
