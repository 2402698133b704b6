// The command as scripts call it: exit codes, JSON keys, files.
#include "client/cli/program.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/client/support/live_client.h"
#include "tests/client/support/silent_port.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli {
namespace {

using nlohmann::json;

constexpr const char* kSquare =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no square\nf 1 2 3\nf 1 3 4\nl 1 2\n";

struct Outcome {
  int exit = 0;
  std::string out;
  std::string err;
};

Outcome run(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "sightline");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int exit = run_program(static_cast<int>(arguments.size()), arguments.data());
  Outcome outcome{exit, testing::internal::GetCapturedStdout(),
                  testing::internal::GetCapturedStderr()};
  return outcome;
}

std::set<std::string> keys_of(const std::string& text) {
  std::set<std::string> keys;
  const json document = json::parse(text);
  for (const auto& [key, value] : document.items()) keys.insert(key);
  return keys;
}

void expect_keys(const std::string& text, const std::set<std::string>& expected) {
  const std::set<std::string> keys = keys_of(text);
  for (const std::string& key : expected) EXPECT_TRUE(keys.contains(key)) << key;
}

class Program : public tests::LiveClient {
 protected:
  Program() { ::setenv("SIGHTLINE_ENDPOINT", endpoint().c_str(), 1); }
  ~Program() override { ::unsetenv("SIGHTLINE_ENDPOINT"); }

  void import_square() {
    const std::string file = dir_.write("square.obj", kSquare);
    ASSERT_EQ(run({"scene", "import", "square", file.c_str()}).exit, 0);
  }

  tests::TempDir dir_;
};

TEST_F(Program, QuietSaysNothingOfWhatWasDone) {
  const std::string file = dir_.write("square.obj", kSquare);
  const std::string updates = dir_.write("ops.ndjson", R"({"put_node": {"node": -1}})");
  const std::string picture = dir_.path("p.png"), scene = dir_.path("s.glb");
  const std::vector<std::vector<const char*>> commands{
      {"scene", "import", "square", file.c_str(), "-q"},
      {"-q", "scene", "import", "square", file.c_str(), "--replace"},
      {"scene", "add", "square", file.c_str(), "--quiet"},
      {"update", "square", "--file", updates.c_str(), "-q"},
      {"prefetch", "square", "-q"},
      {"render", "square", "--out", picture.c_str(), "--size", "8x8", "-q"},
      {"scene", "export", "square", scene.c_str(), "-q"},
      {"scene", "cool", "square", "-q"},
      {"scene", "rm", "square", "-q"}};
  for (const auto& command : commands) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    EXPECT_EQ(outcome.out + outcome.err, "") << command[1];
  }
  const Outcome failed = run({"scene", "import", "square", "none.obj", "-q"});
  EXPECT_EQ(failed.exit, 1);
  EXPECT_NE(failed.err.find("none.obj"), std::string::npos);
  const Outcome asked = run({"scene", "import", "square", file.c_str(), "-q", "--json"});
  expect_keys(asked.out, {"scene", "revision", "triangles_unique"});
}

TEST_F(Program, UsageErrorsExitWithTwo) {
  const std::vector<std::vector<const char*>> wrong{
      {},
      {"fly"},
      {"scene"},
      {"scene", "fly"},
      {"scene", "show"},
      {"scene", "show", "UPPER"},
      {"scene", "ls", "--flag"},
      {"--endpoint", "nowhere", "scene", "ls"},
      {"--deadline", "0", "scene", "ls"},
      {"cast", "s", "--in", "a", "--out", "b", "--kind", "best"},
      {"cast", "s", "--in", "a", "--out", "b", "--fields", "colour"},
      {"cast", "s", "--in", "a", "--out", "b", "--kind", "any", "--fields", "t"},
      {"cast", "s", "--in", "a", "--out", "b", "--build", "some"},
      {"cast", "s", "--in", "a", "--out", "b", "--kind", "count", "--fields", "t"},
      {"cast", "s", "--in", "a", "--out", "b", "--fields", "ray"},
      {"cast", "s", "--in", "a", "--out", "b", "--cull", "both"},
      {"cast", "s", "--in", "a", "--out", "b", "--under", "0"},
      {"cast", "s", "--in", "a", "--out", "b", "--exclude", "-1"},
      {"cast", "s", "--in", "a", "--out", "b", "--max-hits", "3"},
      {"cast", "s", "--in", "a", "--out", "b", "--kind", "all", "--max-hits", "0"},
      {"cast", "s", "--in", "a", "--out", "b.png"},
      {"cast", "s", "--in", "a", "--out-format", "ply"},
      {"scene", "add", "s", "f", "--at", "1,2,3"},
      {"--json", "cast", "s", "--in", "a", "--out", "-"},
      {"cast", "s", "--in", "a", "--out", "-", "--json"},
      {"prefetch"},
      {"prefetch", "s", "--under", "0"},
      {"prefetch", "s", "--kind", "any"},
      {"prefetch", "s", "--rays", "a", "--kind", "best"},
      {"prefetch", "s", "--rays", "a", "--view"},
      {"prefetch", "s", "--eye", "1,2,3"},
      {"prefetch", "s", "--view", "--under", "1", "2"},
      {"prefetch", "s", "--rays", "a", "--under", "1", "2"},
      {"render", "s", "--out", "p.png", "--size", "10"},
      {"render", "s", "--out", "p.png", "--eye", "1,2"},
      {"render", "s", "--out", "p.png", "--mode", "x-ray"},
      {"scene", "import", "s", "f", "--up", "x"},
      {"scene", "import", "s", "f", "--meters-per-unit", "0"},
  };
  for (const auto& arguments : wrong) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit, 2) << (arguments.empty() ? "" : arguments[0]) << ": " << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err, "");
  }
}

TEST_F(Program, HelpHasExamplesForEveryVerb) {
  const std::vector<std::vector<const char*>> verbs{{"--help"},
                                                    {"scene", "--help"},
                                                    {"scene", "import", "--help"},
                                                    {"scene", "ls", "--help"},
                                                    {"scene", "show", "--help"},
                                                    {"scene", "nodes", "--help"},
                                                    {"scene", "rm", "--help"},
                                                    {"cast", "--help"},
                                                    {"nearest", "--help"},
                                                    {"prefetch", "--help"},
                                                    {"render", "--help"},
                                                    {"rtrace", "--help"},
                                                    {"slice", "--help"},
                                                    {"scene", "add", "--help"},
                                                    {"scene", "export", "--help"},
                                                    {"scene", "cool", "--help"},
                                                    {"server", "--help"},
                                                    {"stats", "--help"},
                                                    {"update", "--help"},
                                                    {"stream", "--help"},
                                                    {"watch", "--help"},
                                                    {"load", "--help"}};
  for (const auto& arguments : verbs) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit, 0);
    EXPECT_NE(outcome.out.find("Examples:\n  sightline "), std::string::npos) << outcome.out;
  }
}

TEST_F(Program, AnUnknownSceneExitsWithThree) {
  const std::string rays = dir_.write("rays.csv", "0,0,1,0,0,-1\n");
  const std::string out = dir_.path("out");
  EXPECT_EQ(run({"scene", "show", "none"}).exit, 3);
  EXPECT_EQ(run({"scene", "rm", "none"}).exit, 3);
  EXPECT_EQ(run({"stats", "none"}).exit, 3);
  EXPECT_EQ(run({"prefetch", "none"}).exit, 3);
  EXPECT_EQ(run({"prefetch", "none", "--rays", rays.c_str()}).exit, 3);
  EXPECT_EQ(run({"cast", "none", "--in", rays.c_str(), "--out", out.c_str()}).exit, 3);
  EXPECT_EQ(run({"render", "none", "--out", dir_.path("out.png").c_str()}).exit, 3);
  EXPECT_EQ(dir_.names(), "rays.csv");
}

TEST_F(Program, NoServerExitsWithFive) {
  EXPECT_EQ(run({"scene", "ls", "--endpoint", "127.0.0.1:1"}).exit, 5);
}

TEST_F(Program, ASilentServerExitsWithFive) {
  const tests::SilentPort port;
  EXPECT_EQ(run({"scene", "ls", "--endpoint", port.endpoint().c_str(), "--deadline", "0.1"}).exit,
            5);
}

TEST_F(Program, UnreadableLocalFilesExitWithOne) {
  import_square();
  const std::string none = dir_.path("none");
  const std::string out = dir_.path("out.csv");
  const std::string bad = dir_.write("bad.csv", "0,0,1,0,0,-1\n0,0,1,0,0,down\n");
  EXPECT_EQ(run({"scene", "import", "new", none.c_str()}).exit, 1);
  EXPECT_EQ(run({"scene", "import", "new", bad.c_str()}).exit, 1);
  EXPECT_EQ(run({"cast", "square", "--in", none.c_str(), "--out", out.c_str()}).exit, 1);
  EXPECT_EQ(run({"prefetch", "square", "--rays", none.c_str()}).exit, 1);
  const Outcome malformed = run({"cast", "square", "--in", bad.c_str(), "--out", out.c_str()});
  EXPECT_EQ(malformed.exit, 1);
  EXPECT_NE(malformed.err.find("bad.csv:2: dz is 'down'"), std::string::npos) << malformed.err;
  EXPECT_EQ(dir_.names(), "bad.csv square.obj");
}

TEST_F(Program, AFileThatKillsItsReaderIsOneLineAndExitCode1) {
  const std::string self = dir_.write("self.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><library_nodes>
<node id="n"><instance_node url="#n"/></node></library_nodes><library_visual_scenes>
<visual_scene id="v"><node id="r"><instance_node url="#n"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#v"/></scene></COLLADA>)");
  const Outcome outcome = run({"scene", "import", "new", self.c_str()});
  EXPECT_EQ(outcome.exit, 1);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find("self.dae: "), std::string::npos) << outcome.err;
}

TEST_F(Program, ASceneThatIsRefusedIsRefusedByTheNameOfItsFile) {
  std::string nodes;  // a chain of 1,025
  for (int i = 1; i <= 1024; ++i) nodes += fmt::format(R"({{"children":[{}]}},)", i);
  const std::string deep = dir_.write("deep.gltf", R"({"asset":{"version":"2.0"},"scene":0,
"scenes":[{"nodes":[0]}],"nodes":[)" + nodes + R"({"name":"deepest","mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":
"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
  const Outcome outcome = run({"scene", "import", "new", deep.c_str()});
  EXPECT_EQ(outcome.exit, 1);
  EXPECT_NE(outcome.err.find(deep + ": node 'deepest' is at depth 1025, the limit is 1024"),
            std::string::npos)
      << outcome.err;
}

TEST_F(Program, WarningsOfAnImportAreShown) {
  const std::string cut = dir_.write("cut.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3");
  const Outcome outcome = run({"scene", "import", "new", cut.c_str(), "--json"});
  EXPECT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("sightline: warning: " + cut), std::string::npos) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["warnings"].size(), 1U);
}

TEST_F(Program, ImportReportsItsCounts) {
  const std::string file = dir_.write("square.obj", kSquare);
  const Outcome outcome = run({"scene", "import", "square", file.c_str(), "--json", "--up", "z"});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  expect_keys(outcome.out, {"scene", "revision", "nodes", "instances", "meshes", "triangles_unique",
                            "triangles_instanced", "lines_and_points_skipped",
                            "triangles_nonfinite", "up_axis", "meters_per_unit", "seconds"});
  const json document = json::parse(outcome.out);
  EXPECT_EQ(document["scene"], "projects/default/scenes/square");
  EXPECT_EQ(document["triangles_unique"], 2);
  EXPECT_EQ(document["lines_and_points_skipped"], 1);
  EXPECT_EQ(document["up_axis"], "z");
  EXPECT_EQ(document["meters_per_unit"], nullptr);
}

TEST_F(Program, AnExistingSceneExitsWithFourWithoutReplace) {
  import_square();
  const std::string file = dir_.path("square.obj");
  const Outcome refused = run({"scene", "import", "square", file.c_str()});
  EXPECT_EQ(refused.exit, 4);
  EXPECT_NE(refused.err.find("--replace"), std::string::npos);
  EXPECT_EQ(
      run({"scene", "import", "square", file.c_str(), "--replace", "--mobility", "rigid"}).exit, 0);
}

TEST_F(Program, ScenesAreShownListedAndRemoved) {
  import_square();
  const Outcome show = run({"--json", "scene", "show", "square"});
  ASSERT_EQ(show.exit, 0);
  expect_keys(show.out,
              {"revision", "nodes", "instances", "meshes", "triangles_unique",
               "triangles_instanced", "bounds", "bytes_geometry", "up_axis", "meters_per_unit"});
  EXPECT_EQ(json::parse(show.out)["bounds"].size(), 6U);
  EXPECT_EQ(run({"scene", "show", "projects/default/scenes/square", "--json"}).out, show.out);
  EXPECT_EQ(json::parse(run({"scene", "ls", "--json"}).out)["scenes"].size(), 1U);
  EXPECT_NE(run({"scene", "ls"}).out.find("\nsquare "), std::string::npos);
  EXPECT_EQ(run({"scene", "rm", "square"}).exit, 0);
  EXPECT_TRUE(json::parse(run({"scene", "ls", "--json"}).out)["scenes"].empty());
}

TEST_F(Program, CastWritesHitsAndReportsItsCosts) {
  import_square();
  const std::string rays = dir_.write("rays.csv", "0.75,0.25,2,0,0,-1\n9,9,9,0,0,1\n0,0,0,0,0,0\n");
  const std::string out = dir_.path("hits.csv");
  const Outcome outcome =
      run({"cast", "square", "--in", rays.c_str(), "--out", out.c_str(), "--json"});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  expect_keys(outcome.out,
              {"rays", "hits", "invalid", "revision", "seconds", "rays_per_s", "cells_expanded",
               "trees_built", "triangles_built", "triangles_total", "build_ms", "trace_ms"});
  const json document = json::parse(outcome.out);
  EXPECT_EQ(document["rays"], 3);
  EXPECT_EQ(document["hits"], 1);
  EXPECT_EQ(document["invalid"], 1);
  EXPECT_EQ(document["triangles_total"], 2);
  EXPECT_EQ(dir_.read("hits.csv"),
            "t,node,primitive,u,v,nx,ny,nz\n"
            "2,2,0,0.5,0.25,0,0,1\n"
            "inf,0,0,0,0,0,0,0\n"
            "nan,0,0,0,0,0,0,0\n");
}

TEST_F(Program, CastToStandardOutputPrintsOnlyCsv) {
  import_square();
  const std::string rays =
      dir_.write("rays.csv", "ox,oy,oz,dx,dy,dz\n0.75,0.25,2,0,0,-1\n9,9,9,0,0,1\n0,0,0,0,0,0\n");
  const Outcome outcome =
      run({"cast", "square", "--in", rays.c_str(), "--out", "-", "--kind", "any"});
  EXPECT_EQ(outcome.exit, 0);
  EXPECT_EQ(outcome.out, "hit\n1\n0\n2\n");
  EXPECT_NE(outcome.err.find("3 rays, 1 hits, 1 invalid"), std::string::npos);
}

TEST_F(Program, CastCountsHitsAndListsThem) {
  import_square();
  const std::string rays =
      dir_.write("rays.csv", "0.75,0.25,2,0,0,-1\n9,9,9,0,0,1\n0,0,0,0,0,0\n0.75,0.25,3,0,0,-1\n");
  const auto cast = [&](std::vector<const char*> more) {
    std::vector<const char*> arguments{"cast", "square", "--in", rays.c_str(), "--out", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  EXPECT_EQ(cast({"--kind", "count"}).out, "count\n1\n0\n4294967295\n1\n");
  EXPECT_EQ(cast({"--kind", "all"}).out,
            "ray,t,node,primitive,u,v,nx,ny,nz\n"
            "0,2,2,0,0.5,0.25,0,0,1\n"
            "2,nan,0,0,0,0,0,0,0\n"
            "3,3,2,0,0.5,0.25,0,0,1\n");
  EXPECT_EQ(cast({"--kind", "any", "--cull", "front"}).out, "hit\n0\n0\n2\n0\n");
  EXPECT_EQ(cast({"--kind", "any", "--cull", "back", "--under", "1"}).out, "hit\n1\n0\n2\n1\n");
  EXPECT_EQ(cast({"--kind", "any", "--exclude", "2", "1"}).out, "hit\n0\n0\n2\n0\n");
  const Outcome unknown = cast({"--under", "55"});
  EXPECT_EQ(unknown.exit, 3);
  EXPECT_NE(unknown.err.find("root node 55"), std::string::npos);
  EXPECT_EQ(cast({"--kind", "all", "--max-hits", "16385"}).exit, 1);
}

TEST_F(Program, ListFilesHaveOneRowForEachHit) {
  import_square();
  const std::string rays = dir_.write("rays.csv", "0.75,0.25,2,0,0,-1\n9,9,9,0,0,1\n");
  const std::string out = dir_.path("hits.npy");
  const Outcome outcome = run({"cast", "square", "--in", rays.c_str(), "--out", out.c_str(),
                               "--kind", "all", "--fields", "ray,t", "--json"});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["hits_found"], 1);
  EXPECT_EQ(json::parse(outcome.out)["rays_cut_off"], 0);
  const std::string file = dir_.read("hits.npy");
  EXPECT_NE(file.find("[('ray', '<u8'), ('t', '<f8')]"), std::string::npos);
  EXPECT_NE(file.find("'shape': (1,)"), std::string::npos);
}

TEST_F(Program, PrefetchReportsWhatItHasBuilt) {
  import_square();
  const std::string rays = dir_.write("rays.csv", "0.75,0.25,2,0,0,-1\n9,9,9,0,0,1\n");
  const Outcome none = run({"prefetch", "square", "--exclude", "2", "--json"});
  ASSERT_EQ(none.exit, 0) << none.err;
  EXPECT_EQ(json::parse(none.out)["meshes_total"], 0);
  EXPECT_EQ(json::parse(none.out)["triangles_built"], 0);
  const Outcome touched = run({"prefetch", "square", "--rays", rays.c_str(), "--json"});
  ASSERT_EQ(touched.exit, 0) << touched.err;
  EXPECT_EQ(json::parse(touched.out)["rays"], 2);
  const Outcome all = run({"prefetch", "square", "--under", "1", "2", "--json"});
  ASSERT_EQ(all.exit, 0) << all.err;
  expect_keys(all.out, {"scene", "revision", "complete", "meshes_done", "meshes_total", "rays",
                        "cells_expanded", "trees_built", "triangles_built", "triangles_total",
                        "bytes_trees", "build_ms", "seconds"});
  EXPECT_EQ(json::parse(all.out)["complete"], true);
  EXPECT_EQ(json::parse(all.out)["triangles_built"], 2);
  const std::string out = dir_.path("hits.csv");
  const Outcome cast =
      run({"cast", "square", "--in", rays.c_str(), "--out", out.c_str(), "--json"});
  EXPECT_EQ(json::parse(cast.out)["cells_expanded"], 0);
  EXPECT_NE(run({"prefetch", "square"}).out.find("2 of 2 (100 %) of the scene built"),
            std::string::npos);
  EXPECT_EQ(run({"prefetch", "square", "--under", "55"}).exit, 3);
}

TEST_F(Program, CastInFullCountsTheCellsBuiltFirst) {
  import_square();
  const std::string rays = dir_.write("rays.csv", "9,9,9,0,0,1\n");
  const std::string out = dir_.path("hits.csv");
  const Outcome outcome = run(
      {"cast", "square", "--in", rays.c_str(), "--out", out.c_str(), "--build", "full", "--json"});
  ASSERT_EQ(outcome.exit, 0) << outcome.err;
  const json document = json::parse(outcome.out);
  EXPECT_GT(document["cells_expanded"], 0);
  EXPECT_TRUE(document["build_ms"].is_number());
  EXPECT_EQ(document["triangles_built"], 2);
}

TEST_F(Program, RenderWritesAPngInEveryMode) {
  import_square();
  for (const char* mode : {"normal", "depth", "node", "heat"}) {
    const std::string out = dir_.path(std::string(mode) + ".png");
    const Outcome outcome =
        run({"render", "square", "--out", out.c_str(), "--size", "20x10", "--mode", mode, "--eye",
             "-1,2,3", "--at", "0.5,0.5,0", "--fov", "30", "--json"});
    ASSERT_EQ(outcome.exit, 0) << outcome.err;
    EXPECT_EQ(json::parse(outcome.out)["rays"], 800);
    EXPECT_EQ(dir_.read(std::string(mode) + ".png").substr(1, 3), "PNG");
  }
  const std::string out = dir_.path("none/p.png");
  EXPECT_EQ(run({"render", "square", "--out", out.c_str(), "--size", "4x4"}).exit, 1);
  EXPECT_EQ(run({"render", "square", "--out", out.c_str(), "--eye", "1,1,1", "--at", "1,1,1"}).exit,
            2);
}

TEST_F(Program, StatsHasTheDocumentedKeys) {
  import_square();
  const Outcome outcome = run({"stats", "square", "--json"});
  ASSERT_EQ(outcome.exit, 0);
  expect_keys(outcome.out, {"revision", "instances_total", "instances_entered", "cells_deferred",
                            "cells_expanded", "triangles_built", "triangles_total",
                            "bytes_geometry", "bytes_trees", "static_instances",
                            "dynamic_instances", "static_share", "dynamic_share"});
  EXPECT_EQ(run({"stats", "square"}).exit, 0);
}

}  // namespace
}  // namespace sightline::client::cli
