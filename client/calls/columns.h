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

/// The columns that are not empty.
HitFields fields_of(const HitColumns& hits);

/// Errors: kInvalidArgument for kAll, whose answers have not a row a ray.
Status check_kind(QueryKind kind);

/// Errors: kInvalidArgument, naming the column, where one has not a row a ray.
template <class Scalar>
Status check_rows(const RayColumns<const Scalar>& rays, const HitColumns& hits);

/// Fills all of `room` with the rays from number `first` on.
template <class Scalar>
void copy_rays(const RayColumns<const Scalar>& rays, std::size_t first,
               const RayColumns<Scalar>& room);

/// The rays, message by message. They outlive it.
template <class Scalar>
RaySource<Scalar> source_of(const RayColumns<const Scalar>& rays);

/// Puts the answers in their place, from row `first` on.
void copy_hits(const HitView& answers, std::size_t first, const HitColumns& hits);

}  // namespace sightline::client::calls
