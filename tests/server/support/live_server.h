// A real server in this process on a free port, and a channel to it.
#pragma once

#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/server.h"
#include "tests/server/support/api.h"

namespace sightline::tests {

/// The name of the scene that tests create.
inline const std::string kScene = "projects/p/scenes/s";

inline server::ServerConfig test_config() {
  server::ServerConfig config;
  config.listen = "127.0.0.1:0";
  config.threads = 2;
  config.memory_budget = std::uint64_t{256} << 20;
  return config;
}

/// A separate connection, not shared with other channels of this process. It is open.
std::shared_ptr<grpc::Channel> connect(const std::string& target);
/// To a port of this machine.
std::shared_ptr<grpc::Channel> connect(int port);

class LiveServer : public testing::Test {
 protected:
  explicit LiveServer(const server::ServerConfig& config = test_config());

  std::unique_ptr<server::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  Api api_;
};

}  // namespace sightline::tests
