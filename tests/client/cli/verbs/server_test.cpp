// server tells what the server says of itself.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/client/support/run_program.h"

namespace sightline::tests {
namespace {

using ServerVerb = LiveProgram;

TEST_F(ServerVerb, TellsVersionPolicyAndLimits) {
  const ProgramOutcome outcome = run_program({"server", "--json"});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  const auto reported = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(reported["endpoint"], endpoint());
  EXPECT_NE(reported["version"], "");
  EXPECT_EQ(reported["durable"], false);
  for (const char* limit : {"max_rays_per_request", "max_scenes", "max_connections", "threads"})
    EXPECT_GT(reported[limit], 0) << limit;
  EXPECT_NE(run_program({"server"}).out.find("kept in memory only"), std::string::npos);
}

}  // namespace
}  // namespace sightline::tests
