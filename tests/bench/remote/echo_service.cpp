// A service that answers casts with the bytes that it got.
#include "tests/bench/remote/echo_service.h"

#include <fmt/core.h>
#include <grpcpp/grpcpp.h>

#include <cstdio>
#include <memory>
#include <string>

#include "sightline/v1/query.grpc.pb.h"

namespace sightline::bench {
namespace {

/// The columns have the form of hits: eight bytes a ray.
void echo(const v1::CastRaysRequest& request, v1::CastRaysResponse& reply) {
  const std::string& origins = request.rays().origins();
  v1::HitColumn& column =
      reply.columns_size() == 0 ? *reply.add_columns() : *reply.mutable_columns(0);
  column.set_field(v1::HIT_FIELD_T);
  const std::size_t rays = origins.size() / (3 * (request.rays().float64() ? 8 : 4));
  column.mutable_data()->assign(origins, 0, 8 * rays);
}

class EchoStream final
    : public grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse> {
 public:
  EchoStream() { StartRead(&request_); }
  void OnReadDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::OK);
    echo(request_.request(), *reply_.mutable_response());
    reply_.set_chunk(request_.chunk());
    StartWrite(&reply_);
  }
  void OnWriteDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::CANCELLED);
    StartRead(&request_);
  }
  void OnDone() override { delete this; }

 private:
  v1::StreamCastRaysRequest request_;
  v1::StreamCastRaysResponse reply_;
};

class EchoService final : public v1::RayQueryService::CallbackService {
  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context,
                                     const v1::CastRaysRequest* request,
                                     v1::CastRaysResponse* reply) override {
    echo(*request, *reply);
    grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
    reactor->Finish(grpc::Status::OK);
    return reactor;
  }
  grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>* StreamCastRays(
      grpc::CallbackServerContext*) override {
    return new EchoStream;
  }
};

}  // namespace

Status run_echo_service(const std::string& socket) {
  EchoService service;
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  if (!socket.empty())
    builder.AddListeningPort("unix:" + socket, grpc::InsecureServerCredentials());
  builder.RegisterService(&service);
  const std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  if (server == nullptr) return Error{Code::kUnavailable, "no port for the echo service", "PORT"};
  fmt::print("echo port={}\n", port);
  std::fflush(stdout);
  server->Wait();
  return {};
}

}  // namespace sightline::bench
