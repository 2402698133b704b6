// Rays to messages and hits from messages. Internal to the library. Scalar is float or double.
#pragma once

#include <cstddef>
#include <string>

#include "client/cast_options.h"
#include "client/result.h"
#include "sightline/v1/query.pb.h"

namespace sightline::client::wire {

namespace v1 = ::sightline::v1;

v1::QueryKind encode(QueryKind kind);

/// Says in the request what is asked of the rays that follow.
void describe(const std::string& scene, HitFields fields, const CastOptions& options,
              v1::CastRaysRequest& request);

/// The columns of a message, sized for n rays, to be filled in place.
template <class Scalar>
RayColumns<Scalar> make_room(std::size_t n, RayShape shape, v1::Rays& rays);

/// Cuts the columns down to the first n rays.
template <class Scalar>
void trim(std::size_t n, RayShape shape, v1::Rays& rays);

/// The answer's columns, in place. Errors: kInternal if one that was asked for is missing or has
/// not n rows.
Result<HitView> view_hits(const v1::CastRaysResponse& response, HitFields fields, std::size_t n);

/// A part of an answer that lists all hits. Errors: kInternal as above; also if it does not begin
/// with ray `first` of its batch, or goes beyond its n rays or ends before them.
Result<HitView> view_all_hits(const v1::CastRaysResponse& response, HitFields fields,
                              std::size_t first, std::size_t n);

void add_stats(const v1::CastRaysResponse& response, CastReport& report);

}  // namespace sightline::client::wire
