// The log lines of casts.
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>
#include <string>

#include "server/queries/cast_job.h"
#include "tests/server/queries/random_rays.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

class QueryLogTest : public LiveServer {
 protected:
  QueryLogTest() {
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
