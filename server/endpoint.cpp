// Where clients connect.
#include "server/endpoint.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "server/exec/call_context.h"
#include "server/exec/malformed.h"
#include "server/net/guarded_sockets.h"

namespace sightline::server {
namespace {

/// gRPC buffers a message until it has arrived in full, even if it is over the limit.
constexpr std::uint64_t kLeastForTransport = std::uint64_t{16} << 20;

/// Bytes that a call may send before they are read: 10 MB a second at 100 ms.
constexpr int kWindow = 1 << 20;

/// The time between the end of the last call and the end of the connections, in which clients may
/// close them.
constexpr std::chrono::milliseconds kGoodbye{100};

/// Settings that differ from the library's defaults. They were measured.
void configure(grpc::ServerBuilder& builder, const ServerConfig& config) {
  if (config.max_connection_age.count() > 0) {
    const std::chrono::milliseconds age = config.max_connection_age;
    const std::chrono::milliseconds grace = ServerConfig::kConnectionGrace;
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS, static_cast<int>(age.count()));
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_GRACE_MS,
                               static_cast<int>(grace.count()));
  }
  builder.SetMaxReceiveMessageSize(ServerConfig::kMaxMessageBytes);
  const std::uint64_t quota =
      std::max(exec::MemoryParts::of(config.memory_budget).transport, kLeastForTransport);
  builder.SetResourceQuota(grpc::ResourceQuota("sightline").Resize(quota));
  // Windows that follow the speed of a client would take the whole quota for a fast one, and its
  // call would be given up.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kWindow);
  // gRPC 1.51 compares a message with its limit only after it was decompressed.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, ServerConfig::kMaxCallsPerConnection);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 10'000);
}

/// Adds health checks and reflection, once, to all servers of the process.
void add_plugins() {
  static std::once_flag added;
  std::call_once(added, [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  });
}

}  // namespace

Status Endpoint::serve(const net::ListenAddress& address) {
  auto listening = net::listen_on(address);
  if (!listening) return listening.error();
  add_plugins();
  start_grpc();
  if (grpc_ == nullptr) return Error{Code::kInternal, "gRPC does not start", "NOT_STARTED"};
  accept(std::move(*listening));
  return {};
}

void Endpoint::start_grpc() {
  grpc::ServerBuilder builder;
  configure(builder, state_.config);
  for (grpc::Service* service : std::initializer_list<grpc::Service*>{
           &query_rpc_, &scene_rpc_, &blob_rpc_, &backup_rpc_, &info_rpc_})
    builder.RegisterService(service);
  using Type = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
  auto experimental = builder.experimental();
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(metrics::measure_calls(state_.metrics.rpcs));
  interceptors.push_back(exec::count_calls(open_rpcs_));
  interceptors.push_back(exec::refuse_malformed());
  interceptors.push_back(exec::log_refusals(refusal_log_));
  interceptors.push_back(exec::pace_refusals(refusal_pace_));
  experimental.SetInterceptorCreators(std::move(interceptors));
  builder.SetContextAllocator(exec::make_contexts(access_.authenticator->calls()));
  connections_ = experimental.AddExternalConnectionAcceptor(
      Type::FROM_FD,
      access_.tls != nullptr ? access_.tls->credentials() : grpc::InsecureServerCredentials());
  grpc_ = builder.BuildAndStart();
}

void Endpoint::accept(net::ListeningSockets listening) {
  port_ = listening.port;
  socket_file_ = std::move(listening.file);
  acceptor_ = std::make_unique<net::Acceptor>(
      std::move(listening.sockets), max_connections_,
      net::Acceptor::Events{
          .accepted =
              [this](int listener, net::Descriptor connection) {
                if (!net::guard_socket(connection.number(),
                                       {.max_streams = ServerConfig::kMaxCallsPerConnection,
                                        .tls = access_.tls != nullptr,
                                        .ended = ended_connections_}))
                  return;
                const net::TlsOf made(connection.number());
                grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
                parameters.listener_fd = listener;
                parameters.fd = connection.release();
                connections_->HandleNewConnection(&parameters);
              },
          .failed =
              [this] {
                acceptor_failed_.store(true);
                not_serving();
              },
          .ended = [this] { return ended_connections_->take_addresses(); }});
}

Status Endpoint::accepts() const {
  if (!acceptor_failed_.load()) return {};
  return Error{Code::kUnavailable, "no connection is accepted any more", "ACCEPTOR_FAILED"};
}

std::shared_ptr<grpc::Channel> Endpoint::in_process() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);  // what the services answer is bounded by themselves
  return grpc_->InProcessChannel(arguments);
}

void Endpoint::not_serving() {
  set_serving(false);
  const std::lock_guard lock(health_);
  ended_ = true;
}

void Endpoint::set_serving(bool serving) {
  const std::lock_guard lock(health_);
  if (ended_ || serving == serving_) return;
  serving_ = serving;
  grpc_->GetHealthCheckService()->SetServingStatus(serving);
}

void Endpoint::shut_down() {
  refusal_pace_.stop();
  state_.stop_waiting();
  acceptor_->stop();
  socket_file_ = {};
  const std::jthread idle([this](std::stop_token stop) { close_idle(std::move(stop)); });
  grpc_->Shutdown(std::chrono::system_clock::now() + state_.config.drain);
}

/// Closes the connections when no call is open any more: gRPC would wait for clients that do not
/// look at them.
void Endpoint::close_idle(std::stop_token stop) {
  open_rpcs_.wait_for_none(state_.config.drain);
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any().wait_for(lock, std::move(stop), kGoodbye, [] { return false; });
  acceptor_->shut_down();
}

}  // namespace sightline::server
