// The verbs update, watch and stream, as scripts call them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/client/importer/gltf_file.h"
#include "tests/client/support/run_program.h"

namespace sightline::client::cli::playback {
namespace {

using nlohmann::json;
using tests::ProgramOutcome;
using tests::run_program;

class MovingScenes : public tests::LiveProgram {
 protected:
  // t of a ray along -z from far above (x, y); inf for a miss.
  double t_above(const std::string& scene, double x, double y,
                 const std::vector<std::string>& flags = {}) {
    const std::string rays = dir_.write("rays.csv", fmt::format("{},{},100,0,0,-1\n", x, y));
    std::vector<std::string> arguments{"cast", scene, "--in", rays, "--out", "-", "--fields", "t"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const ProgramOutcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    return outcome.out.size() > 2 ? std::stod(outcome.out.substr(2)) : -1;
  }

  json stream(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "stream");
    arguments.push_back("--json");
    const ProgramOutcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    return outcome.exit == 0 ? json::parse(outcome.out) : json();
  }

  std::string strip() { return dir_.write("strip.gltf", tests::bending_strip().text()); }
};

using UpdateVerb = MovingScenes;

TEST_F(UpdateVerb, AppliesAllLinesOrNone) {
  ASSERT_TRUE(client_.create_scene("projects/default/scenes/s"));
  const std::string ops = dir_.write("ops.ndjson", R"({"put_node": {"node": -1, "name": "a"}}

{"put_node": {"node": -2, "parent": -1, "name": "b"}}
)");
  const ProgramOutcome outcome =
      run_program({"update", "s", "--file", ops, "--request-id", "one", "--json"});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  const json done = json::parse(outcome.out);
  EXPECT_EQ(done["revision"], 1);
  EXPECT_EQ(done["nodes"], (std::vector<int>{1, 2}));
  EXPECT_EQ(done["replayed"], false);
  EXPECT_FALSE(done["token"].get<std::string>().empty());
  const json again =
      json::parse(run_program({"update", "s", "--file", ops, "--request-id", "one", "--json"}).out);
  EXPECT_EQ(again["replayed"], true);
  EXPECT_EQ(again["revision"], 1);
  EXPECT_EQ(again["nodes"], done["nodes"]);

  const std::string bad = dir_.write("bad.ndjson", R"({"delete_node": {"node": 2}}
{"delete_node": {"node": 99}}
)");
  EXPECT_EQ(run_program({"update", "s", "--file", bad}).exit, 3);
  EXPECT_EQ(client_.get_scene("projects/default/scenes/s")->revision, 1U);
  EXPECT_EQ(run_program({"update", "s", "--file", ops, "--expect-revision", "7"}).exit, 4);
  EXPECT_EQ(run_program({"update", "none", "--file", ops}).exit, 3);
}

TEST_F(UpdateVerb, NamesFileLineAndKey) {
  const std::string ops = dir_.write("ops.ndjson", R"({"delete_node": {"node": 2}}

{"set_transforms": {"nodes": [1], "matrices": [[1]]}}
)");
  const ProgramOutcome outcome = run_program({"update", "s", "--file", ops});
  EXPECT_EQ(outcome.exit, 1);
  EXPECT_NE(
      outcome.err.find(ops + ": line 3: set_transforms.matrices row 0 is not 12 or 16 numbers"),
      std::string::npos)
      << outcome.err;
  EXPECT_EQ(run_program({"update", "s", "--file", dir_.path("none")}).exit, 1);
  EXPECT_EQ(run_program({"update", "s"}).exit, 2);
  EXPECT_EQ(run_program({"update", "s", "--file", ops, "--request-id", ""}).exit, 2);
}

TEST_F(UpdateVerb, ListsNodesWithTheirState) {
  ASSERT_TRUE(client_.create_scene("projects/default/scenes/s"));
  const std::string ops = dir_.write("ops.ndjson", R"({"put_node": {"node": -1, "name": "a"}}
{"put_node": {"node": -2, "parent": -1, "name": "b", "mobility": "rigid", "mask": 3}}
)");
  ASSERT_EQ(run_program({"update", "s", "--file", ops}).exit, 0);
  const json nodes = json::parse(run_program({"scene", "nodes", "s", "--json"}).out)["nodes"];
  ASSERT_EQ(nodes.size(), 2U);
  EXPECT_EQ(nodes[1]["id"], 2);
  EXPECT_EQ(nodes[1]["parent"], 1);
  EXPECT_EQ(nodes[1]["name"], "b");
  EXPECT_EQ(nodes[1]["mobility"], "rigid");
  EXPECT_EQ(nodes[1]["mask"], 3);
  EXPECT_NE(run_program({"scene", "nodes", "s"}).out.find("2         1  rigid      -        b"),
            std::string::npos);
  EXPECT_EQ(run_program({"scene", "nodes", "none"}).exit, 3);
}

using WatchVerb = MovingScenes;

TEST_F(WatchVerb, PrintsOneLineForEachRevision) {
  ASSERT_TRUE(client_.create_scene("projects/default/scenes/s"));
  const std::string ops = dir_.write("ops", R"({"put_node": {"node": -1, "name": "a"}})");
  for (int k = 0; k < 2; ++k) ASSERT_EQ(run_program({"update", "s", "--file", ops}).exit, 0);
  const ProgramOutcome outcome = run_program({"watch", "s", "--from", "0", "--count", "2"});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  const std::size_t end = outcome.out.find('\n');
  const json first = json::parse(outcome.out.substr(0, end));
  const json second = json::parse(outcome.out.substr(end + 1));
  EXPECT_EQ(first["revision"], 1);
  EXPECT_EQ(second["revision"], 2);
  EXPECT_EQ(second["updates"][0]["put_node"]["node"], 2);
  EXPECT_EQ(run_program({"watch", "s", "--from", "9"}).exit, 1);
  EXPECT_EQ(run_program({"watch", "none"}).exit, 3);
  EXPECT_EQ(run_program({"watch", "s", "--count", "0"}).exit, 2);
}

using StreamVerb = MovingScenes;

TEST_F(StreamVerb, ImportsTheSceneAndPosesIt) {
  const json bent = stream({"strip", "--animate", strip(), "--time", "1"});
  EXPECT_EQ(bent["imported"], true);
  EXPECT_EQ(bent["frames_sent"], 1);
  EXPECT_EQ(bent["meshes_deformed"], 1);
  EXPECT_EQ(bent["nodes_moved"], 1);
  // Its upper half lies to the left.
  EXPECT_EQ(t_above("strip", -0.9, 1), 100);
  EXPECT_TRUE(std::isinf(t_above("strip", 0.3, 1.9)));
  const json straight = stream({"strip", "--animate", strip(), "--frame", "0"});
  EXPECT_EQ(straight["imported"], false);
  EXPECT_EQ(t_above("strip", 0.3, 1.9), 100);
  EXPECT_TRUE(std::isinf(t_above("strip", -0.9, 1)));
  EXPECT_EQ(t_above("strip", -0.9, 1, {"--revision", bent["revision"].dump()}), 100);
  EXPECT_EQ(t_above("strip", 0.3, 1.9, {"--at-least", straight["token"].get<std::string>()}), 100);
}

TEST_F(StreamVerb, ReportsAllFigures) {
  const json report = stream({"strip", "--animate", strip(), "--fps", "200", "--loops", "1"});
  for (const char* key :
       {"scene", "animation", "frames_sent", "frames_unchanged", "frames_late", "frames_dropped",
        "seconds", "fps_asked", "fps_achieved", "ack_p50_ms", "ack_p99_ms", "coalesced", "rejected",
        "reconnects", "bytes_sent", "revision", "token", "complete"}) {
    EXPECT_TRUE(report.contains(key)) << key;
  }
  const int frames = report["frames_sent"].get<int>() + report["frames_late"].get<int>() +
                     report["frames_unchanged"].get<int>() + report["frames_dropped"].get<int>();
  EXPECT_EQ(frames, 201);
  EXPECT_EQ(report["rejected"], 0);
  EXPECT_EQ(t_above("strip", -0.9, 1), 100) << "it ends with the animation's last moment";
  const ProgramOutcome table =
      run_program({"stream", "strip", "--animate", strip(), "--fps", "200", "--seconds", "0.02"});
  EXPECT_EQ(table.exit, 0);
  EXPECT_NE(table.out.find("at revision"), std::string::npos);
}

TEST_F(StreamVerb, PlaysIntoASceneWithOtherNodes) {
  const std::string floor =
      dir_.write("floor.obj", "v -9 -9 -5\nv 9 -9 -5\nv 9 9 -5\nv -9 9 -5\nf 1 2 3\nf 1 3 4\n");
  ASSERT_EQ(run_program({"scene", "import", "hall", floor}).exit, 0);
  EXPECT_EQ(run_program({"stream", "hall", "--animate", strip()}).exit, 4)
      << "the strip is not there";
  EXPECT_EQ(t_above("hall", 0.3, 1.9), 105);
  const json added = stream({"hall", "--animate", strip(), "--add", "--time", "0"});
  EXPECT_EQ(added["imported"], false);
  EXPECT_EQ(t_above("hall", 0.3, 1.9), 100);
  stream({"hall", "--animate", strip(), "--time", "1"});
  EXPECT_EQ(t_above("hall", 0.3, 1.9), 105);
  EXPECT_EQ(t_above("hall", -0.9, 1), 100);
}

TEST_F(StreamVerb, KeepsTheUpAxisAndUnitOfTheScene) {
  ASSERT_EQ(run_program({"scene", "import", "strip", strip(), "--up", "z"}).exit, 0);
  stream({"strip", "--animate", strip(), "--time", "0"});
  const std::string rays = dir_.write("rays.csv", "0.3,50,1.9,0,-1,0\n");
  const ProgramOutcome outcome =
      run_program({"cast", "strip", "--in", rays, "--out", "-", "--fields", "t"});
  EXPECT_EQ(outcome.out, "t\n50\n");
}

TEST_F(StreamVerb, MovesOnlyTheRequestedNodes) {
  tests::GltfFile file = tests::triangle_under_root();
  file.animate(0, "translation", {0, 1}, {0, 0, 0, 0, 0, 7});
  file.animate(1, "translation", {0, 1}, {0, 0, 0, 0, 0, 20});
  const std::string path = dir_.write("file.gltf", file.text());
  stream({"s", "--animate", path, "--time", "1", "--node", "blade"});
  EXPECT_EQ(t_above("s", 0.2, 0.2), 80);
  stream({"s", "--animate", path, "--time", "1", "--node", "1"});
  EXPECT_EQ(t_above("s", 0.2, 0.2), 73);
  EXPECT_EQ(run_program({"stream", "s", "--animate", path, "--node", "door"}).exit, 1);
}

TEST_F(StreamVerb, PlaysAFolderOfFrames) {
  const tests::TempDir frames;
  for (int k = 0; k < 3; ++k) {
    frames.write(fmt::format("f{}.obj", k),
                 fmt::format("v 0 0 {0}\nv 1 0 {0}\nv 0 1 {0}\nf 1 2 3\n", k));
  }
  const json played = stream({"s", "--animate", frames.path(""), "--fps", "100", "--loops", "3"});
  EXPECT_EQ(played["meshes_deformed"], 1);
  EXPECT_EQ(t_above("s", 0.2, 0.2), 98);
  stream({"s", "--animate", frames.path(""), "--frame", "1"});
  EXPECT_EQ(t_above("s", 0.2, 0.2), 99);
  stream({"s", "--animate", frames.path(""), "--frame", "3"});
  EXPECT_EQ(t_above("s", 0.2, 0.2), 100) << "frames come around";
}

TEST_F(StreamVerb, ReportsErrors) {
  const std::string unanimated = dir_.write("still.gltf", tests::triangle_under_root().text());
  const ProgramOutcome none = run_program({"stream", "s", "--animate", unanimated});
  EXPECT_EQ(none.exit, 1);
  EXPECT_NE(none.err.find("holds no animation"), std::string::npos);
  EXPECT_EQ(run_program({"stream", "s", "--animate", dir_.path("none")}).exit, 1);
  EXPECT_EQ(run_program({"stream", "s", "--animate", strip(), "--add"}).exit, 3);
  stream({"s", "--animate", strip(), "--time", "0"});
  EXPECT_EQ(run_program({"stream", "s", "--animate", strip(), "--create"}).exit, 4);
  const std::vector<std::vector<std::string>> wrong{
      {"stream", "s"},
      {"stream", "s", "--animate", "x", "--fps", "0"},
      {"stream", "s", "--animate", "x", "--seconds", "-1"},
      {"stream", "s", "--animate", "x", "--seconds", "1", "--loops", "1"},
      {"stream", "s", "--animate", "x", "--frame", "1", "--time", "1"},
      {"stream", "s", "--animate", "x", "--producer", "a b"},
      {"stream", "s", "--animate", "x", "--add", "--create"},
      {"cast", "s", "--in", "a", "--out", "b", "--revision", "1", "--at-least", "x"},
  };
  for (const auto& arguments : wrong) EXPECT_EQ(run_program(arguments).exit, 2) << arguments.back();
}

}  // namespace
}  // namespace sightline::client::cli::playback
