// The log lines of casts.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "server/queries/cast_job.h"
#include "tests/server/queries/random_rays.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

server::ServerConfig log_config(std::chrono::milliseconds slow_query) {
  server::ServerConfig config = test_config();
  config.slow_query = slow_query;
  return config;
}

class QueryLogTest : public LiveServer {
 protected:
  explicit QueryLogTest(std::chrono::milliseconds slow_query = {})
      : LiveServer(log_config(slow_query)) {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log_)));
    spdlog::set_level(spdlog::level::debug);
  }
  ~QueryLogTest() override {
    server_.reset();
    spdlog::set_default_logger(before_);
    spdlog::set_level(spdlog::level::err);
  }

  /// The line of the only call of this method. A call is logged before it is answered.
  std::string line_of(const std::string& method) const {
    std::istringstream lines(log_.str());
    for (std::string line; std::getline(lines, line);) {
      if (line.find("method=" + method + " ") != std::string::npos) return line;
    }
    return "no line of " + method;
  }

  const std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
  std::ostringstream log_;
};

TEST_F(QueryLogTest, NamesTheSceneTheCallerTheRaysAndWhatWasBuilt) {
  api_.make_scene(kScene, random_soup(2000, 0.1, 11));
  v1::CastRaysResponse reply;
  // More than one slice.
  ASSERT_TRUE(
      api_.cast(cast_request(kScene, random_rays(3 * server::queries::kRaysPerSlice, 3)), &reply)
          .ok());
  const std::string line = line_of("CastRays");
  for (const std::string& part :
       {"scene=" + kScene, std::string("peer=ipv4:127.0.0.1:"), std::string("queue_us="),
        "rays=" + std::to_string(reply.stats().rays()),
        "cells=" + std::to_string(reply.stats().cells_expanded()), std::string("trees=2")})
    EXPECT_NE(line.find(part + (part.ends_with(':') || part.ends_with('=') ? "" : " ")),
              std::string::npos)
        << part << " in " << line;
  EXPECT_GT(reply.stats().cells_expanded(), 0u);
}

TEST_F(QueryLogTest, HasTheIdThatTheClientGave) {
  grpc::ClientContext context;
  context.AddMetadata("x-request-id", "a \"b\" " + std::string(200, 'c'));
  v1::GetSceneRequest request;
  request.set_name("projects/p/scenes/none");
  v1::GetSceneResponse reply;
  EXPECT_FALSE(api_.scenes->GetScene(&context, request, &reply).ok());
  const std::string line = line_of("GetScene");
  EXPECT_NE(line.find(" request_id=\"a \\\"b\\\" cc"), std::string::npos) << line;
  EXPECT_EQ(line.find(std::string(100, 'c')), std::string::npos) << "it is cut";
  ASSERT_TRUE(api_.create(kScene).ok());
  EXPECT_EQ(line_of("CreateScene").find("request_id"), std::string::npos);
}

constexpr const char* kTraceParent = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
constexpr const char* kTrace = " trace_id=4bf92f3577b34da6a3ce929d0e0e4736";

TEST_F(QueryLogTest, HasTheTraceOfAValidHeaderOnly) {
  const auto line_with = [&](const std::vector<std::string>& headers) {
    log_.str({});
    grpc::ClientContext context;
    for (const std::string& header : headers) context.AddMetadata("traceparent", header);
    context.AddMetadata("x-request-id", "n");
    v1::GetSceneRequest request;
    request.set_name("projects/p/scenes/none");
    v1::GetSceneResponse reply;
    EXPECT_FALSE(api_.scenes->GetScene(&context, request, &reply).ok());
    return line_of("GetScene");
  };
  EXPECT_NE(line_with({kTraceParent}).find(std::string(" request_id=\"n\"") + kTrace + " error="),
            std::string::npos)
      << log_.str();
  EXPECT_EQ(line_with({kTraceParent, kTraceParent}).find("trace_id"), std::string::npos);
  EXPECT_EQ(line_with({"00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01"}).find("trace_id"),
            std::string::npos);
}

TEST_F(QueryLogTest, WhoDeletesASceneIsTraced) {
  ASSERT_TRUE(api_.create(kScene).ok());
  grpc::ClientContext context;
  context.AddMetadata("traceparent", kTraceParent);
  v1::DeleteSceneRequest request;
  request.set_name(kScene);
  v1::DeleteSceneResponse reply;
  ASSERT_TRUE(api_.scenes->DeleteScene(&context, request, &reply).ok());
  EXPECT_NE(log_.str().find("event=scene_deleted scene=" + kScene + kTrace), std::string::npos)
      << log_.str();
}

TEST_F(QueryLogTest, ARefusedCallHasALine) {
  api_.make_scene(kScene, random_soup(10, 0.1, 11));
  grpc::ClientContext context;
  context.AddMetadata("traceparent", kTraceParent);
  v1::BatchGetNodesRequest nodes;
  nodes.set_scene(kScene);
  for (std::uint64_t id = 0; id < 513; ++id) nodes.add_ids(id);
  v1::BatchGetNodesResponse reply;
  EXPECT_EQ(api_.scenes->BatchGetNodes(&context, nodes, &reply).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  const std::string text = log_.str();
  const std::size_t at = text.find("event=refused method=BatchGetNodes code=8 reason=");
  ASSERT_NE(at, std::string::npos) << text;
  const std::string line = text.substr(at, text.find('\n', at) - at);
  EXPECT_NE(line.find(" peer=ipv4:127.0.0.1:"), std::string::npos) << line;
  EXPECT_TRUE(line.ends_with(std::string(" since_last=1") + kTrace)) << line;
}

/// A query of some size is slow.
class SlowQueryTest : public QueryLogTest {
 protected:
  SlowQueryTest() : QueryLogTest(std::chrono::milliseconds(1)) {}

  /// The only line of a slow query; empty if there is none.
  std::string slow_line() const {
    const std::string text = log_.str();
    const std::size_t at = text.find("event=slow_query ");
    return at == std::string::npos ? std::string() : text.substr(at, text.find('\n', at) - at);
  }
};

TEST_F(SlowQueryTest, IsLoggedWithWhatItBuilt) {
  // On a busy machine tracing takes longer, never less.
  api_.make_scene(kScene, random_soup(200'000, 0.01, 11));
  EXPECT_EQ(slow_line(), "");
  v1::CastRaysRequest request = cast_request(kScene, random_rays(16'000, 3));
  request.set_build(v1::BUILD_MODE_FULL);
  grpc::ClientContext context;
  context.AddMetadata("x-request-id", "slow one");
  context.AddMetadata("traceparent", kTraceParent);
  v1::CastRaysResponse reply;
  ASSERT_TRUE(api_.rays->CastRays(&context, request, &reply).ok());
  const std::string line = slow_line();
  for (const std::string& part :
       {std::string("method=CastRays request_id=\"slow one\"") + kTrace + " scene=" + kScene,
        std::string("rays=16000 "), "cells=" + std::to_string(reply.stats().cells_expanded()) + " ",
        std::string("trees=2 ")})
    EXPECT_NE(line.find(part), std::string::npos) << part << " in " << line;
}

TEST_F(QueryLogTest, AFullBuildIsNamed) {
  api_.make_scene(kScene, random_soup(2000, 0.1, 11));
  v1::CastRaysRequest request = cast_request(kScene, random_rays(1, 3));
  request.set_build(v1::BUILD_MODE_FULL);
  v1::CastRaysResponse reply;
  ASSERT_TRUE(api_.cast(request, &reply).ok());
  EXPECT_GT(reply.stats().cells_expanded(), 1u);
  EXPECT_NE(line_of("CastRays").find("trees=2 "), std::string::npos) << line_of("CastRays");
}

}  // namespace
}  // namespace sightline::tests
