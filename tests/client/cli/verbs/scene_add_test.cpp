// Nodes of a file come into a scene, below a node and at a place.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/client/support/run_program.h"
#include "tests/client/support/square.h"

namespace sightline::tests {
namespace {

using nlohmann::json;

class SceneAdd : public LiveProgram {
 protected:
  SceneAdd() : square_(dir_.write("s.obj", kSquareObj)) {
    EXPECT_EQ(run_program({"scene", "import", "hall", square_}).exit, 0);
  }

  // The distance that a ray down from z = 100 goes.
  std::string distance(const std::string& x) const {
    const std::string rays = dir_.write("r.txt", x + " 0.25 100 0 0 -1\n");
    return run_program({"cast", "hall", "--in", rays, "--fields", "t", "--no-header"}).out;
  }

  std::string square_;
};

TEST_F(SceneAdd, PutsRootsBelowANodeByName) {
  const ProgramOutcome added =
      run_program({"scene", "add", "hall", square_, "--under", "square", "--json"});
  ASSERT_EQ(added.exit, 0) << added.err;
  const auto ids = json::parse(added.out)["nodes"];
  const auto nodes = json::parse(run_program({"scene", "nodes", "hall", "--json"}).out)["nodes"];
  EXPECT_EQ(nodes.size(), 2 * ids.size());
  for (const auto& node : nodes) {
    if (node["id"] != ids[0]) continue;
    EXPECT_EQ(node["parent"], 2);
  }
}

TEST_F(SceneAdd, TakesMatricesOf12And16) {
  EXPECT_EQ(distance("10.75"), "inf\n");
  ASSERT_EQ(run_program({"scene", "add", "hall", square_, "--at", "1,0,0,10,0,1,0,0,0,0,1,7"}).exit,
            0);
  EXPECT_EQ(distance("10.75"), "93\n");
  const std::vector<std::string> sixteen{"scene", "add", "hall", square_, "--at", "1", "0",
                                         "0",     "20",  "0",    "1",     "0",    "0", "0",
                                         "0",     "1",   "8",    "0",     "0",    "0", "1"};
  ASSERT_EQ(run_program(sixteen).exit, 0);
  EXPECT_EQ(distance("20.75"), "92\n");
}

TEST_F(SceneAdd, WrongMatricesAreUsageErrors) {
  const auto fault = [&](const std::string& numbers) {
    const ProgramOutcome outcome = run_program({"scene", "add", "hall", square_, "--at", numbers});
    EXPECT_EQ(outcome.exit, 2);
    return outcome.err;
  };
  EXPECT_NE(fault("1,0,0,0,0,1,0,0,0,0,1,0,10,0,0,1").find("column by column; give it row by row"),
            std::string::npos);
  EXPECT_NE(fault("1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,2").find("last row of a matrix of 16"),
            std::string::npos);
  EXPECT_NE(fault("1,0,0,0,0,1,0,0,0,0,1,0,0"), "");
  EXPECT_NE(fault("1,2,3"), "");
}

TEST_F(SceneAdd, UnknownNodesAndFilesAreErrors) {
  EXPECT_EQ(run_program({"scene", "add", "hall", square_, "--under", "shelf"}).exit, 3);
  EXPECT_EQ(run_program({"scene", "add", "hall", dir_.path("none.obj")}).exit, 1);
  EXPECT_EQ(run_program({"scene", "add", "none", square_}).exit, 3);
}

}  // namespace
}  // namespace sightline::tests
