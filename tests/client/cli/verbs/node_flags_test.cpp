// The nodes that count, in each verb that has the flags.
#include "client/cli/verbs/node_flags.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/client/support/boxes.h"
#include "tests/client/support/run_program.h"

namespace sightline::tests {
namespace {

class NodeFlags : public LiveProgram {
 protected:
  NodeFlags() {
    std::vector boxes{mesh_of({{0, 0, 0}, {1, 1, 1}}), mesh_of({{0, 0, 5}, {1, 1, 6}})};
    boxes[0].name = "low";
    boxes[1].name = "high";
    EXPECT_EQ(run_program({"scene", "import", "s", dir_.write("s.obj", obj_of(boxes))}).exit, 0);
    const std::string ray = dir_.write("ray.txt", "0.25 0.5 9 0 0 -1\n");
    const std::string point = dir_.write("point.txt", "0.25 0.5 9\n");
    verbs_ = {{"cast", "s", "--in", ray, "--fields", "t", "--no-header"},
              {"nearest", "s", "--in", point, "--fields", "distance", "--no-header"}};
  }

  static ProgramOutcome run(std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }

  std::vector<std::vector<std::string>> verbs_;
};

TEST_F(NodeFlags, RaysAndPointsSeeTheSameNodes) {
  for (const auto& verb : verbs_) {
    EXPECT_EQ(run(verb, {}).out, "3\n") << verb[0];
    EXPECT_EQ(run(verb, {"--exclude", "high"}).out, "8\n") << verb[0];
    EXPECT_EQ(run(verb, {"--under", "low"}).out, "8\n") << verb[0];
    EXPECT_EQ(run(verb, {"--under", "high", "--exclude", "low"}).out, "3\n") << verb[0];
    EXPECT_EQ(run(verb, {"--exclude", "high", "low"}).out, "inf\n") << verb[0];
    EXPECT_EQ(run(verb, {"--exclude", "high", "--exclude", "low"}).out, "inf\n") << verb[0];
  }
}

TEST_F(NodeFlags, LabelsSelectNodes) {
  const auto nodes =
      nlohmann::json::parse(run_program({"scene", "nodes", "s", "--json"}).out)["nodes"];
  std::string lines;
  for (const auto& node : nodes) {
    nlohmann::json put = node;
    for (const char* key : {"id", "patched"}) put.erase(key);
    put["node"] = node["id"];
    put["labels"] = {{"level", node["name"]}, {"a=b", "c=d"}};
    lines += nlohmann::json{{"put_node", put}}.dump() + "\n";
  }
  ASSERT_EQ(run_program({"update", "s", "--file", dir_.write("labels.ndjson", lines)}).exit, 0);
  for (const auto& verb : verbs_) {
    EXPECT_EQ(run(verb, {"--exclude-label", "level=high"}).out, "8\n") << verb[0];
    EXPECT_EQ(run(verb, {"--only-label", "level=low"}).out, "8\n") << verb[0];
    EXPECT_EQ(run(verb, {"--only-label", "level=low", "level=high"}).out, "3\n") << verb[0];
    EXPECT_EQ(run(verb, {"--exclude-label", "level"}).out, "inf\n") << verb[0];
    EXPECT_EQ(run(verb, {"--exclude-label", "level="}).out, "3\n") << verb[0];
    EXPECT_EQ(run(verb, {"--only-label", "a=b=c=d"}).out, "inf\n") << "a key has no '='";
    EXPECT_EQ(run(verb, {"--exclude-label", "=high"}).exit, 2) << verb[0];
    EXPECT_EQ(run(verb, {"--only-label", ""}).exit, 2) << verb[0];
    EXPECT_NE(run(verb, {"--only-label", std::string(65, 'k')}).err.find("the limit is 64"),
              std::string::npos);
  }
}

TEST_F(NodeFlags, NodesThatAreNotThereAreErrors) {
  for (const auto& verb : verbs_) {
    EXPECT_EQ(run(verb, {"--under", "hihg"}).exit, 3) << verb[0];
    EXPECT_EQ(run(verb, {"--exclude", "hihg"}).exit, 3) << verb[0];
    EXPECT_EQ(run(verb, {"--under", "-1"}).exit, 2) << verb[0];
    EXPECT_EQ(run(verb, {"--time-budget", "0"}).exit, 2) << verb[0];
  }
}

TEST_F(NodeFlags, HelpIsInTheWordsOfWhatIsAsked) {
  EXPECT_NE(run_program({"cast", "--help"}).out.find("rays without an answer"), std::string::npos);
  for (const char* verb : {"nearest", "slice"}) {
    const std::string help = run_program({verb, "--help"}).out;
    for (const char* flag : {"--under NODE", "--exclude NODE ...", "--time-budget MS"})
      EXPECT_NE(help.find(flag), std::string::npos) << verb << ' ' << flag;
    EXPECT_NE(help.find("points without an answer"), std::string::npos) << verb;
  }
}

}  // namespace
}  // namespace sightline::tests
