// Servers of this process that share a store in PostgreSQL, for tests.
#include "tests/server/replicas/replicas.h"

#include <grpcpp/client_context.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <sstream>
#include <thread>
#include <utility>

#include "tests/server/support/http.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::tests {

ReplicaServer::ReplicaServer(const server::ServerConfig& config) {
  spdlog::set_level(spdlog::level::err);
  auto started = server::Server::start(config);
  EXPECT_TRUE(started) << started.error().message;
  if (!started) return;
  server_ = std::move(*started);
  channel_ = server_->port() == 0 ? connect(config.listen) : connect(server_->port());
  api_ = std::make_unique<Api>(channel_);
}

std::string ReplicaServer::readiness() const { return http_get(server_->admin_port(), "/readyz"); }

double ReplicaServer::metric(const std::string& name) const {
  std::istringstream lines(http_get(server_->admin_port(), "/metrics"));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(name + " ")) return std::stod(line.substr(name.size() + 1));
  }
  ADD_FAILURE() << "there is no metric " << name;
  return 0;
}

void ReplicaTest::SetUp() {
  if (!PostgresServer::installed()) GTEST_SKIP() << "PostgreSQL is not installed";
  PostgresServer& postgres = PostgresServer::shared();
  uri_ = postgres.uri(postgres.make_database());
}

std::unique_ptr<ReplicaServer> ReplicaTest::start(const Change& change) const {
  server::ServerConfig config = test_config();
  config.store = uri_;
  config.admin = "127.0.0.1:0";
  if (change) change(config);
  return std::make_unique<ReplicaServer>(config);
}

void ReplicaTest::start_three() {
  a_ = start();
  b_ = start();
  c_ = start();
}

v1::ApplyUpdatesRequest request_of(const std::string& id, const std::vector<v1::Update>& updates) {
  v1::ApplyUpdatesRequest request;
  request.set_scene(kScene);
  request.set_request_id(id);
  request.mutable_updates()->Assign(updates.begin(), updates.end());
  return request;
}

grpc::Status apply_request(Api& api, const v1::ApplyUpdatesRequest& request,
                           v1::ApplyUpdatesResponse* reply) {
  grpc::ClientContext context;
  return api.scenes->ApplyUpdates(&context, request, reply);
}

v1::ApplyUpdatesResponse apply_surely(Api& api, const std::string& id,
                                      const std::vector<v1::Update>& updates) {
  const v1::ApplyUpdatesRequest request = request_of(id, updates);
  for (;;) {
    v1::ApplyUpdatesResponse reply;
    const grpc::Status applied = apply_request(api, request, &reply);
    if (applied.ok()) return reply;
    if (applied.error_code() == grpc::StatusCode::UNAVAILABLE) continue;
    ADD_FAILURE() << applied.error_message();
    return reply;
  }
}

grpc::Status cast_at(Api& api, const std::string& token, v1::CastRaysResponse* reply) {
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(20));
  for (const v1::HitField field : {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE,
                                   v1::HIT_FIELD_HIT, v1::HIT_FIELD_BARYCENTRIC})
    request.add_fields(field);
  if (!token.empty()) request.mutable_consistency()->set_at_least(token);
  return api.cast(request, reply);
}

std::string hits_of(const v1::CastRaysResponse& reply) {
  std::string all;
  for (const v1::HitColumn& column : reply.columns()) all += column.SerializeAsString();
  EXPECT_FALSE(all.empty());
  return all;
}

grpc::Status nodes_at(Api& api, const std::string& token, const std::vector<std::uint64_t>& ids,
                      v1::BatchGetNodesResponse* reply) {
  grpc::ClientContext context;
  v1::BatchGetNodesRequest request;
  request.set_scene(kScene);
  request.mutable_ids()->Assign(ids.begin(), ids.end());
  if (!token.empty()) request.mutable_consistency()->set_at_least(token);
  return api.scenes->BatchGetNodes(&context, request, reply);
}

void wait_until(const std::function<bool()>& done) {
  while (!done()) sleep_shortly();
}

}  // namespace sightline::tests
