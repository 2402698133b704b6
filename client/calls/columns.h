// Copies between the columns of a caller and those of a message. Internal to the library.
#pragma once

#include <cstddef>
#include <cstdint>

#include "client/cast_options.h"
#include "client/result.h"

namespace sightline::client::calls {

template <class Scalar>
RayShape shape_of(const RayColumns<const Scalar>& rays) {
  return {!rays.tmin.empty() || !rays.tmax.empty(), !rays.masks.empty()};
}

/// The fields of the columns that are not empty.
HitFields fields_of(const HitColumns& hits);

/// Errors: kInvalidArgument for kAll, because its answers do not have one row per ray.
Status check_kind(QueryKind kind);

/// Errors: kInvalidArgument, naming the column, if a column does not have one row per ray.
Status check_rows(std::size_t rays, const HitColumns& hits);
template <class Scalar>
Status check_rows(const RayColumns<const Scalar>& rays, const HitColumns& hits);

/// Fills all of `buffer` with rays, beginning with ray `first`.
template <class Scalar>
void copy_rays(const RayColumns<const Scalar>& rays, std::size_t first,
               const RayColumns<Scalar>& buffer);

/// A source that gives the rays message by message. The columns of `rays` must outlive it.
template <class Scalar>
RaySource<Scalar> source_of(const RayColumns<const Scalar>& rays);

/// Copies the answers into the columns, beginning at row `first`: a multiple of 8 if there are
/// bits.
void copy_hits(const HitView& answers, std::size_t first, const HitColumns& hits);

}  // namespace sightline::client::calls
