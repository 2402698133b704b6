// Casts whose rays or answers are in a segment, for tests.
#pragma once

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "server/queries/hit_codec.h"
#include "sightline/v1/query.pb.h"
#include "tests/server/support/live_server.h"
#include "tests/server/support/shared_segment.h"

namespace sightline::tests {

inline server::ServerConfig config_with_segments() {
  server::ServerConfig config = test_config();
  config.segments = server::segments::Offer::kLocal;
  return config;
}

/// The request with its rays in the segment.
inline v1::CastRaysRequest with_rays_in(SharedSegment& segment, v1::CastRaysRequest request) {
  const v1::Rays rays = request.rays();
  v1::SharedRays& shared = *request.mutable_shared();
  shared.set_float64(rays.float64());
  shared.set_count(rays.origins().size() / (rays.float64() ? 24 : 12));
  shared.set_origins(segment.put(rays.origins()));
  shared.set_directions(segment.put(rays.directions()));
  if (!rays.tmin().empty()) shared.set_tmin(segment.put(rays.tmin()));
  if (!rays.tmax().empty()) shared.set_tmax(segment.put(rays.tmax()));
  if (!rays.masks().empty()) shared.set_masks(segment.put(rays.masks()));
  request.set_segment(segment.name());
  return request;
}

/// The request with its points in the segment.
inline v1::QueryPointsRequest with_points_in(SharedSegment& segment,
                                             v1::QueryPointsRequest request) {
  const v1::Points points = request.points();
  v1::SharedPoints& shared = *request.mutable_shared();
  shared.set_float64(points.float64());
  shared.set_count(points.positions().size() / (points.float64() ? 24 : 12));
  shared.set_positions(segment.put(points.positions()));
  if (!points.max_distance().empty()) shared.set_max_distance(segment.put(points.max_distance()));
  if (!points.masks().empty()) shared.set_masks(segment.put(points.masks()));
  request.set_segment(segment.name());
  return request;
}

/// The request with its fields in the segment, for this number of rays.
template <class Request>
Request with_answer_in(SharedSegment& segment, Request request, std::size_t rays) {
  request.set_segment(segment.name());
  for (const int number : request.fields()) {
    v1::SharedColumn& column = *request.add_answer();
    column.set_field(static_cast<v1::HitField>(number));
    column.set_offset(segment.reserve(server::queries::column_bytes(column.field(), rays, rays)));
  }
  request.clear_fields();
  return request;
}

/// The columns of the answer, wherever they are: in the reply, or in the request's segment.
template <class Request, class Reply>
std::vector<std::string> columns_of(const SharedSegment& segment, const Request& request,
                                    const Reply& reply, std::size_t rays) {
  std::vector<std::string> columns;
  for (const v1::HitColumn& column : reply.columns()) columns.push_back(column.data());
  if (request.answer_size() == 0) return columns;
  EXPECT_TRUE(columns.empty()) << "the reply has columns, too";
  for (const v1::SharedColumn& column : request.answer())
    columns.push_back(
        segment.column(column.offset(), server::queries::column_bytes(column.field(), rays, rays)));
  return columns;
}

/// A server that offers segments, and one that is open.
class SegmentRpc : public LiveServer {
 protected:
  SegmentRpc() : SegmentRpc(config_with_segments()) {}
  explicit SegmentRpc(const server::ServerConfig& config) : LiveServer(config) {}

  template <class Reply, class Request>
  Reply ask(const Request& request) {
    Reply reply;
    const grpc::Status status = api_.cast(request, &reply);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return reply;
  }

  template <class Reply, class Request>
  std::string refusal(const Request& request) {
    Reply reply;
    return reason_of(api_.cast(request, &reply));
  }

  v1::GetServerInfoResponse info() {
    grpc::ClientContext context;
    v1::GetServerInfoResponse reply;
    EXPECT_TRUE(api_.server->GetServerInfo(&context, {}, &reply).ok());
    return reply;
  }

  /// What the server holds for segments.
  std::uint64_t held() {
    const v1::GetServerInfoResponse reply = info();
    for (const v1::HeldBytes& one : reply.memory()) {
      if (one.kind() == "segments") return one.bytes();
    }
    ADD_FAILURE() << "segments are not reported";
    return 0;
  }
};

}  // namespace sightline::tests
