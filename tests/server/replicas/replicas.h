// Servers of this process that share a store in PostgreSQL, for tests.
#pragma once

#include <grpcpp/channel.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/server.h"
#include "tests/server/store/postgres/postgres_server.h"
#include "tests/server/support/api.h"
#include "tests/server/support/live_server.h"

namespace sightline::tests {

/// One of the servers, and a connection to it.
class ReplicaServer {
 public:
  /// Fails the test if it does not start.
  explicit ReplicaServer(const server::ServerConfig& config);

  Api& api() { return *api_; }
  /// A connection of its own, as each busy thread needs.
  std::shared_ptr<grpc::Channel> connect_again() const { return connect(server_->port()); }
  /// The reply of /readyz: the status and the text.
  std::string readiness() const;
  /// The value of a metric; fails the test if there is none.
  double metric(const std::string& name) const;

 private:
  std::unique_ptr<server::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Api> api_;
};

/// Skipped where PostgreSQL is not installed.
class ReplicaTest : public testing::Test {
 protected:
  void SetUp() override;

  /// Changes the settings of a server.
  using Change = std::function<void(server::ServerConfig&)>;
  std::unique_ptr<ReplicaServer> start(const Change& change = {}) const;
  /// Starts a_, b_ and c_.
  void start_three();

  /// The servers' store; by default a database of the server that all tests use.
  std::string uri_;
  std::unique_ptr<ReplicaServer> a_, b_, c_;
};

/// What clients of several servers do.

/// Applies updates with a request id, again while the server says UNAVAILABLE.
v1::ApplyUpdatesResponse apply_surely(Api& api, const std::string& id,
                                      const std::vector<v1::Update>& updates);
grpc::Status apply_request(Api& api, const v1::ApplyUpdatesRequest& request,
                           v1::ApplyUpdatesResponse* reply);
v1::ApplyUpdatesRequest request_of(const std::string& id, const std::vector<v1::Update>& updates);
/// Casts rays at the scene, once it is no older than the token (empty: as it is).
grpc::Status cast_at(Api& api, const std::string& token, v1::CastRaysResponse* reply);
/// All columns of a reply.
std::string hits_of(const v1::CastRaysResponse& reply);
/// The nodes of these ids, at a revision no older than the token.
grpc::Status nodes_at(Api& api, const std::string& token, const std::vector<std::uint64_t>& ids,
                      v1::BatchGetNodesResponse* reply);
/// Calls done() until it returns true.
void wait_until(const std::function<bool()>& done);

}  // namespace sightline::tests
