// Rays and points to messages, and hits from messages. Internal to the library. Scalar is float or
// double, Request v1::CastRaysRequest or v1::QueryPointsRequest, Response the answer to one.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "client/cast_options.h"
#include "client/points.h"
#include "client/result.h"
#include "sightline/v1/query.pb.h"

namespace sightline::client::wire {

namespace v1 = ::sightline::v1;

/// A time budget on the wire: 0 for none, and at least 1 for any other, even a negative one.
std::uint32_t milliseconds_of(std::chrono::milliseconds budget);

/// Writes the options of the cast to the request.
template <class Request>
void describe(const std::string& scene, HitFields fields, const CastOptions& options,
              Request& request);

/// The columns of a message, sized for n rows. The caller fills them in place.
template <class Scalar>
RayColumns<Scalar> resize_columns(std::size_t n, RayShape shape, v1::Rays& rays);
template <class Scalar>
PointColumns<Scalar> resize_columns(std::size_t n, PointShape shape, v1::Points& points);

/// Reduces the columns to the first n rows.
template <class Scalar>
void trim(std::size_t n, RayShape shape, v1::Rays& rays) {
  resize_columns<Scalar>(n, shape, rays);
}
template <class Scalar>
void trim(std::size_t n, PointShape shape, v1::Points& points) {
  resize_columns<Scalar>(n, shape, points);
}

/// The columns of the answer, without copying. Errors: kInternal if a requested column is missing
/// or does not have n rows.
template <class Response>
Result<HitView> view_hits(const Response& response, HitFields fields, std::size_t n);

/// Completes a view of columns that are not in the response: with the rays that have no answer,
/// and, if they were asked for, the names of the rows in hits.name. Errors: as view_hits(), and if
/// a row has no name.
template <class Response>
Status complete_view(const Response& response, bool has_names, std::size_t n, HitView& hits);

/// A part of an answer that lists all hits. Errors: kInternal as view_hits(), and if the part does
/// not begin with ray `first` of its batch, exceeds its n rays, or ends the batch before them.
template <class Response>
Result<HitView> view_all_hits(const Response& response, HitFields fields, std::size_t first,
                              std::size_t n);

template <class Response>
void add_stats(const Response& response, CastReport& report);

}  // namespace sightline::client::wire
