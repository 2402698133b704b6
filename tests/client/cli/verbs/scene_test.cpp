// scene cool drops trees, and answers stay as they were.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/support/run_program.h"
#include "tests/client/support/square.h"

namespace sightline::tests {
namespace {

using SceneVerbs = LiveProgram;

TEST_F(SceneVerbs, CoolDropsTreesThatRaysGrowAgain) {
  ASSERT_EQ(run_program({"scene", "import", "square", dir_.write("s.obj", kSquareObj)}).exit, 0);
  const std::string rays = dir_.write("r.txt", "0.75 0.25 2 0 0 -1\n");
  const auto built = [] {
    const std::string stats = run_program({"stats", "square", "--json"}).out;
    return nlohmann::json::parse(stats)["triangles_built"];
  };
  const std::string before = run_program({"cast", "square", "--in", rays}).out;
  EXPECT_EQ(built(), 2);
  const ProgramOutcome cooled = run_program({"scene", "cool", "square", "--json"});
  ASSERT_EQ(cooled.exit, 0) << cooled.err;
  EXPECT_GT(nlohmann::json::parse(cooled.out)["bytes_freed"], 0);
  EXPECT_EQ(built(), 0);
  EXPECT_EQ(run_program({"cast", "square", "--in", rays}).out, before);
  EXPECT_EQ(run_program({"scene", "cool", "none"}).exit, 3);
}

}  // namespace
}  // namespace sightline::tests
