// Queries of points through a real server, for tests.
#pragma once

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "sightline/v1/query.grpc.pb.h"
#include "tests/server/support/live_server.h"

namespace sightline::tests {

inline std::string bytes_of(const std::vector<double>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double)};
}

template <class T>
std::vector<T> values(const v1::QueryPointsResponse& reply, v1::HitField field) {
  for (const v1::HitColumn& column : reply.columns()) {
    if (column.field() != field) continue;
    std::vector<T> out(column.data().size() / sizeof(T));
    std::memcpy(out.data(), column.data().data(), column.data().size());
    return out;
  }
  ADD_FAILURE() << "no column " << v1::HitField_Name(field);
  return {};
}

class PointsRpc : public LiveServer {
 protected:
  using LiveServer::LiveServer;

  grpc::Status ask(const v1::QueryPointsRequest& request, v1::QueryPointsResponse& reply) {
    grpc::ClientContext context;
    return queries_->QueryPoints(&context, request, &reply);
  }

  v1::QueryPointsResponse answer(const v1::QueryPointsRequest& request) {
    v1::QueryPointsResponse reply;
    const grpc::Status status = ask(request, reply);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return reply;
  }

  std::string refusal(const v1::QueryPointsRequest& request) {
    v1::QueryPointsResponse reply;
    const grpc::Status status = ask(request, reply);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    return status.error_message();
  }

  const std::unique_ptr<v1::RayQueryService::Stub> queries_ =
      v1::RayQueryService::NewStub(channel_);
};

inline v1::QueryPointsRequest points_request(const std::vector<double>& positions,
                                             v1::QueryKind kind = v1::QUERY_KIND_CLOSEST,
                                             const std::vector<v1::HitField>& fields = {}) {
  v1::QueryPointsRequest request;
  request.set_scene(kScene);
  request.set_kind(kind);
  for (const v1::HitField field : fields) request.add_fields(field);
  request.mutable_points()->set_float64(true);
  request.mutable_points()->set_positions(bytes_of(positions));
  return request;
}

}  // namespace sightline::tests
