// A real server in this process on a free port, and a channel to it.
#include "tests/server/support/live_server.h"

#include <grpc/grpc.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

namespace sightline::tests {
namespace {

std::unique_ptr<server::Server> start(const server::ServerConfig& config) {
  spdlog::set_level(spdlog::level::err);
  auto server = server::Server::start(config);
  EXPECT_TRUE(server) << server.error().message;
  return server ? std::move(*server) : nullptr;
}

}  // namespace

std::shared_ptr<grpc::Channel> connect(int port) {
  return connect("127.0.0.1:" + std::to_string(port));
}

std::shared_ptr<grpc::Channel> connect(const std::string& target) {
  // Never released: when its last user is destroyed, the library waits up to ten seconds for its
  // client's poller.
  static const bool library_held = (grpc_init(), true);
  static_cast<void>(library_held);
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  auto channel = grpc::CreateCustomChannel(target, grpc::InsecureChannelCredentials(), arguments);
  // gRPC 1.51 reads errno of connect() too late, and now and then an attempt fails for no reason.
  // The limit only ends a failing test.
  EXPECT_TRUE(
      channel->WaitForConnected(std::chrono::system_clock::now() + std::chrono::minutes(1)));
  return channel;
}

LiveServer::LiveServer(const server::ServerConfig& config)
    : server_(start(config)), channel_(connect(server_->port())), api_(channel_) {}

}  // namespace sightline::tests
