// The admin port of a whole server: its metrics, and its readiness while it drains.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <sstream>
#include <string>
#include <thread>

#include "tests/server/queries/random_rays.h"
#include "tests/server/support/http.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::tests {
namespace {

server::ServerConfig with_admin() {
  server::ServerConfig config = test_config();
  config.admin = "127.0.0.1:0";
  config.not_ready = std::chrono::milliseconds(300);
  config.metrics_per_scene = true;
  config.quotas.others = {0, 0, 1000, 0};
  return config;
}

class AdminPort : public LiveServer {
 protected:
  AdminPort() : LiveServer(with_admin()) {}

  std::string get(const std::string& path) const { return http_get(server_->admin_port(), path); }

  /// The value of a metric with exactly these labels; -1 if there is none.
  double metric(const std::string& name) const {
    const std::string text = get("/metrics");
    const std::size_t at = text.find("\n" + name + " ");
    return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 2));
  }
};

TEST_F(AdminPort, CountsRaysHitsAndBuilds) {
  EXPECT_EQ(metric("sightline_rays_total{kind=\"closest\"}"), 0);
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysResponse reply;
  auto request = cast_request(kScene, rays_downward(1000));
  ASSERT_TRUE(api_.cast(request, &reply).ok());
  EXPECT_EQ(metric("sightline_rays_total{kind=\"closest\"}"), 1000);
  EXPECT_EQ(metric("sightline_hits_total{kind=\"closest\"}"),
            static_cast<double>(reply.stats().hits()));
  EXPECT_EQ(metric("sightline_batch_seconds_count{kind=\"closest\"}"), 1);
  EXPECT_GT(metric("sightline_tree_builds_total{reason=\"lazy\"}"), 0);
  EXPECT_EQ(metric("sightline_tree_builds_total{reason=\"full\"}"), 0);
  EXPECT_EQ(metric("sightline_tree_build_seconds_count"), 1);
  request.set_build(v1::BUILD_MODE_FULL);
  request.set_kind(v1::QUERY_KIND_ANY);
  request.clear_fields();
  api_.make_scene("projects/p/scenes/full", random_soup(2000, 0.1, 11));
  request.set_scene("projects/p/scenes/full");
  ASSERT_TRUE(api_.cast(request, &reply).ok());
  EXPECT_EQ(metric("sightline_rays_total{kind=\"any\"}"), 1000);
  EXPECT_GT(metric("sightline_tree_builds_total{reason=\"full\"}"), 0);
}

TEST_F(AdminPort, CountsCallsByTheirStatus) {
  EXPECT_EQ(api_.create("no name").error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  ASSERT_TRUE(api_.create(kScene).ok());
  const std::string method =
      "grpc_method=\"CreateScene\",grpc_service=\"sightline.v1.SceneService\",grpc_type=\"unary\"";
  EXPECT_EQ(metric("grpc_server_started_total{" + method + "}"), 2);
  // A call ends after its client has its status.
  while (metric("grpc_server_handling_seconds_count{" + method + "}") < 2) sleep_shortly();
  EXPECT_EQ(metric("grpc_server_handled_total{grpc_code=\"OK\"," + method + "}"), 1);
  EXPECT_EQ(metric("grpc_server_handled_total{grpc_code=\"INVALID_ARGUMENT\"," + method + "}"), 1);
}

TEST_F(AdminPort, OldNamesOfMetricsHaveTheSameValues) {
  const std::string text = get("/metrics");
  for (const std::string name : {"rays_total", "batch_seconds", "scenes", "quota_limit"}) {
    EXPECT_NE(
        text.find("\n# HELP " + name +
                  " Deprecated, the next version does not have it: use sightline_" + name + ".\n"),
        std::string::npos)
        << name;
  }
  EXPECT_EQ(metric("memory_budget_bytes"), metric("sightline_memory_budget_bytes"));
  EXPECT_EQ(metric("tree_bytes_evicted_total"), metric("sightline_tree_evicted_bytes_total"));
  EXPECT_EQ(metric("queue_limit{unit=\"rays\"}"), metric("sightline_queue_limit_rays"));
  EXPECT_EQ(metric("queue_limit{unit=\"bytes\"}"), metric("sightline_queue_limit_bytes"));
  EXPECT_EQ(text.find("\nbuild_info"), std::string::npos);

  // Prometheus refuses a text in which a name has two types, or two parts.
  std::map<std::string, int> types;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("# TYPE ")) ++types[line.substr(7, line.find(' ', 7) - 7)];
  }
  for (const auto& [name, count] : types) EXPECT_EQ(count, 1) << name;
}

TEST_F(AdminPort, EveryNameBeginsAsItMust) {
  std::istringstream lines(get("/metrics"));
  for (std::string line, help; std::getline(lines, line);) {
    if (line.starts_with("# HELP ")) help = line;
    if (!line.starts_with("# TYPE ") || help.find(" Deprecated, ") != std::string::npos) continue;
    const std::string name = line.substr(7, line.find(' ', 7) - 7);
    EXPECT_TRUE(name.starts_with("sightline_") || name.starts_with("grpc_server_") ||
                name.starts_with("process_"))
        << name;
    EXPECT_EQ(line.ends_with(" counter"), name.ends_with("_total")) << line;
  }
}

TEST_F(AdminPort, ShowsWhatIsHeldAndLimited) {
  api_.make_scene(kScene, planar_sheet(1));
  EXPECT_EQ(metric("sightline_memory_budget_bytes"),
            static_cast<double>(test_config().memory_budget));
  EXPECT_GT(metric("sightline_memory_used_bytes{kind=\"meshes\"}"), 0);
  EXPECT_EQ(metric("sightline_queue_rays"), 0);
  EXPECT_GT(metric("sightline_queue_limit_rays"), 0);
  EXPECT_EQ(metric("sightline_quota_limit{principal=\"others\",quota=\"concurrent-work\"}"), 1000);
  EXPECT_EQ(metric("sightline_quota_refused_total{principal=\"others\",quota=\"concurrent-work\"}"),
            0);
  EXPECT_EQ(metric("sightline_scenes"), 1);
  EXPECT_GT(metric("sightline_scene_revision{scene=\"" + kScene + "\"}"), 0);
  EXPECT_GT(metric("process_resident_memory_bytes"), 1e6);
  EXPECT_GT(metric("process_open_fds"), 3);
  EXPECT_GT(metric("process_start_time_seconds"), 1.6e9);
  EXPECT_NE(get("/metrics").find("\nsightline_build_info{"), std::string::npos);
}

TEST_F(AdminPort, IsNotReadyBeforeCallsAreRefused) {
  EXPECT_TRUE(get("/readyz").starts_with("HTTP/1.1 200 "));
  std::thread drain([this] { server_->drain(); });
  while (get("/readyz").starts_with("HTTP/1.1 200 ")) sleep_shortly();
  EXPECT_NE(get("/readyz").find("draining"), std::string::npos);
  EXPECT_TRUE(get("/livez").starts_with("HTTP/1.1 200 "));
  drain.join();
  EXPECT_TRUE(get("/readyz").starts_with("HTTP/1.1 503 "));
  EXPECT_FALSE(api_.create(kScene).ok());
}

TEST(AdminAddress, MustBeLoopbackUnlessInsecure) {
  server::ServerConfig config = test_config();
  config.admin = "0.0.0.0:0";
  const auto refused = server::Server::check(config);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "INSECURE_ADDRESS");
  EXPECT_FALSE(server::Server::start(config));
  config.insecure = true;
  EXPECT_TRUE(server::Server::check(config));
}

TEST(AdminAddress, TakenIsAnError) {
  server::ServerConfig config = with_admin();
  const auto first = server::Server::start(config);
  ASSERT_TRUE(first);
  config.admin = "127.0.0.1:" + std::to_string((*first)->admin_port());
  const auto second = server::Server::start(config);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().reason, "PORT_UNAVAILABLE");
}

TEST(ConnectionAge, AsksClientsToConnectAgain) {
  server::ServerConfig config = test_config();
  config.max_connection_age = std::chrono::seconds(1);
  const auto server = server::Server::start(config);
  ASSERT_TRUE(server);
  const auto channel = connect((*server)->port());
  // The connection ends, though nothing has failed, and calls go on.
  ASSERT_TRUE(channel->WaitForStateChange(
      GRPC_CHANNEL_READY, std::chrono::system_clock::now() + std::chrono::minutes(1)));
  EXPECT_TRUE(Api(channel).create(kScene).ok());
}

}  // namespace
}  // namespace sightline::tests
