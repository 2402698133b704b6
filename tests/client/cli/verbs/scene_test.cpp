// scene cool drops trees, and answers stay as they were; scene ls lists a project or all.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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

TEST_F(SceneVerbs, LsListsAProjectOrAll) {
  const std::string file = dir_.write("s.obj", kSquareObj);
  for (const char* name : {"here", "projects/site/scenes/there", "projects/site/scenes/yard"})
    ASSERT_EQ(run_program({"scene", "import", name, file}).exit, 0);
  const auto names = [](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"scene", "ls", "--json"});
    std::vector<std::string> found;
    const auto listed = nlohmann::json::parse(run_program(flags).out);
    for (const auto& scene : listed["scenes"]) found.push_back(scene["scene"]);
    return found;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names({}), (Names{"projects/default/scenes/here"}));
  EXPECT_EQ(names({"--project", "site"}),
            (Names{"projects/site/scenes/there", "projects/site/scenes/yard"}));
  EXPECT_EQ(names({"--project", "none"}), Names());
  EXPECT_EQ(names({"--all"}), (Names{"projects/default/scenes/here", "projects/site/scenes/there",
                                     "projects/site/scenes/yard"}));
  const std::string table = run_program({"scene", "ls", "--all"}).out;
  EXPECT_NE(table.find("\nhere "), std::string::npos) << table;
  EXPECT_NE(table.find("\nprojects/site/scenes/yard "), std::string::npos) << table;

  for (const std::string wrong : {"", "-", "Site", "a/b", "projects/site", "*"}) {
    const ProgramOutcome refused = run_program({"scene", "ls", "--project", wrong});
    EXPECT_EQ(refused.exit, 2) << wrong;
  }
  EXPECT_NE(run_program({"scene", "ls", "--project", "a/b"}).err.find("'a/b' is no project"),
            std::string::npos);
  EXPECT_EQ(run_program({"scene", "ls", "--all", "--project", "site"}).exit, 2);
}

}  // namespace
}  // namespace sightline::tests
