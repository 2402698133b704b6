// A real server in this process on a free port, and a channel to it.
#include "tests/server/support/live_server.h"

#include <grpc/grpc.h>
#include <spdlog/spdlog.h>

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
  // Never released: when its last user is destroyed, the library waits up to ten seconds for its
  // client's poller.
  static const bool library_held = (grpc_init(), true);
  static_cast<void>(library_held);
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(port),
                                   grpc::InsecureChannelCredentials(), arguments);
}

LiveServer::LiveServer(const server::ServerConfig& config)
    : server_(start(config)), channel_(connect(server_->port())), api_(channel_) {}

}  // namespace sightline::tests
