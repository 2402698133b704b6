// The calls about rays and those about points: their messages are alike, field for field. Internal
// to the library.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "client/calls/side_check.h"
#include "client/cast_options.h"
#include "client/points.h"
#include "client/ray_generator.h"
#include "client/result.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::client::calls {

namespace v1 = ::sightline::v1;

/// What belongs to a request: a reply, the messages of a stream, and the methods.
template <class Request>
struct CallsOf;

// In each, clear_own() clears the options that the other does not have.
template <>
struct CallsOf<v1::CastRaysRequest> {
  using Response = v1::CastRaysResponse;
  using StreamRequest = v1::StreamCastRaysRequest;
  using StreamResponse = v1::StreamCastRaysResponse;

  /// Errors: kInvalidArgument, what is about points alone.
  static Status check(const CastOptions& options, HitFields fields) {
    return check_no_sides(options, fields);
  }
  static grpc::Status call(v1::RayQueryService::Stub& stub, grpc::ClientContext& context,
                           const v1::CastRaysRequest& request, Response& response) {
    return stub.CastRays(&context, request, &response);
  }
  static void begin(v1::RayQueryService::Stub& stub, grpc::ClientContext& context,
                    const v1::CastRaysRequest& request, Response& response,
                    std::function<void(grpc::Status)> ended) {
    stub.async()->CastRays(&context, &request, &response, std::move(ended));
  }
  static auto open(v1::RayQueryService::Stub& stub, grpc::ClientContext& context) {
    return stub.StreamCastRays(&context);
  }
  static void clear_own(v1::CastRaysRequest& request) { request.clear_culling(); }
};

template <>
struct CallsOf<v1::QueryPointsRequest> {
  using Response = v1::QueryPointsResponse;
  using StreamRequest = v1::StreamQueryPointsRequest;
  using StreamResponse = v1::StreamQueryPointsResponse;

  /// Errors: kInvalidArgument, what is about rays alone, and those of check_sides().
  static Status check(const CastOptions& options, HitFields fields) {
    if (options.culling == Culling::kNone) return check_sides(options, fields);
    return Error{
        Code::kInvalidArgument, "points see both sides of a face: culling must be kNone", {}};
  }
  static grpc::Status call(v1::RayQueryService::Stub& stub, grpc::ClientContext& context,
                           const v1::QueryPointsRequest& request, Response& response) {
    return stub.QueryPoints(&context, request, &response);
  }
  static void begin(v1::RayQueryService::Stub& stub, grpc::ClientContext& context,
                    const v1::QueryPointsRequest& request, Response& response,
                    std::function<void(grpc::Status)> ended) {
    stub.async()->QueryPoints(&context, &request, &response, std::move(ended));
  }
  static auto open(v1::RayQueryService::Stub& stub, grpc::ClientContext& context) {
    return stub.StreamQueryPoints(&context);
  }
  static void clear_own(v1::QueryPointsRequest& request) {
    request.clear_side_rule();
    request.clear_side_rays();
  }
};

template <class Rows>
struct RequestOfRows;
template <class Scalar>
struct RequestOfRows<RayColumns<Scalar>> {
  using Type = v1::CastRaysRequest;
};
template <class Scalar>
struct RequestOfRows<PointColumns<Scalar>> {
  using Type = v1::QueryPointsRequest;
};
template <>
struct RequestOfRows<RayGenerator> {
  using Type = v1::CastRaysRequest;
};
template <>
struct RequestOfRows<PointGrid> {
  using Type = v1::QueryPointsRequest;
};

/// The request that has such rows: columns of any kind, or what makes them.
template <class Rows>
using RequestOf = typename RequestOfRows<Rows>::Type;

}  // namespace sightline::client::calls
