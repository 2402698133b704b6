// What is exported and imported again is hit by the same rays.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/scene_upload.h"
#include "tests/client/support/run_program.h"
#include "tests/client/support/square.h"

namespace sightline::tests {
namespace {

class SceneExport : public LiveProgram {
 protected:
  // A room with three nodes that share a mesh; the last is patched.
  SceneExport() {
    auto scene = row_of_sheets(3);
    scene.up_axis = client::UpAxis::kZ;
    scene.meters_per_unit = 0.5;
    EXPECT_TRUE(upload_scene(client_, kScene, scene, {}));
    const std::string patch = dir_.write(
        "p.ndjson", R"({"patch_vertices": {"nodes": [4], "first": 0, "positions": [[0, 0, -9]]}})");
    EXPECT_EQ(run_program({"update", "test", "--file", patch}).exit, 0);
  }

  std::string hits(const std::string& scene) const {
    std::string rays;
    for (int i = 0; i < 32; ++i)
      rays +=
          std::to_string(i) + ".3 0.2 50 0.01 0.01 -1\n" + std::to_string(i) + ".7 0.9 50 0 0 -1\n";
    return run_program({"cast", scene, "--in", dir_.write("r.txt", rays), "--fields",
                        "t,primitive,nx,ny,nz", "--no-header"})
        .out;
  }
};

TEST_F(SceneExport, GlbKeepsNodesMeshesAndFaces) {
  const std::string file = dir_.path("test.glb");
  const ProgramOutcome out = run_program({"scene", "export", "test", file, "--json"});
  ASSERT_EQ(out.exit, 0) << out.err;
  const auto reported = nlohmann::json::parse(out.out);
  EXPECT_EQ(reported["nodes"], 4);
  EXPECT_EQ(reported["meshes"], 2) << "the patched one, and the one that is shared";
  EXPECT_EQ(reported["bytes"], dir_.read("test.glb").size());
  ASSERT_EQ(
      run_program({"scene", "import", "again", file, "--up", "z", "--meters-per-unit", "0.5"}).exit,
      0);
  const std::string before = hits("test");
  EXPECT_NE(before.find("0,0,1"), std::string::npos);
  EXPECT_EQ(hits("again"), before);
  const std::string nodes = run_program({"scene", "nodes", "again"}).out;
  EXPECT_NE(nodes.find(" room\n"), std::string::npos) << nodes;
  EXPECT_NE(nodes.find(" sheet"), std::string::npos) << nodes;
}

TEST_F(SceneExport, ObjIsInSceneCoordinates) {
  const std::string file = dir_.path("test.obj");
  ASSERT_EQ(run_program({"scene", "export", "test", file}).exit, 0);
  ASSERT_EQ(run_program({"scene", "import", "again", file}).exit, 0);
  EXPECT_EQ(hits("again"), hits("test"));
}

TEST_F(SceneExport, AFaceWithoutATriangleKeepsItsNumber) {
  const std::string lined =
      dir_.write("l.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no q\nl 1 2\nf 1 2 3\nf 1 3 4\n");
  ASSERT_EQ(run_program({"scene", "import", "lined", lined}).exit, 0);
  ASSERT_EQ(run_program({"scene", "export", "lined", dir_.path("l.glb")}).exit, 0);
  ASSERT_EQ(run_program({"scene", "import", "again", dir_.path("l.glb")}).exit, 0);
  EXPECT_EQ(hits("again"), hits("lined"));
}

TEST_F(SceneExport, OtherSuffixesAndScenesAreRefused) {
  const ProgramOutcome suffix = run_program({"scene", "export", "test", dir_.path("test.stl")});
  EXPECT_EQ(suffix.exit, 2);
  EXPECT_NE(suffix.err.find("scenes are written as .glb, with their nodes, or as .obj"),
            std::string::npos);
  EXPECT_EQ(run_program({"scene", "export", "none", dir_.path("n.glb")}).exit, 3);
  EXPECT_EQ(run_program({"scene", "export", "test", dir_.path("no/n.glb")}).exit, 1);
}

TEST_F(SceneExport, ASceneWithoutNodesIsAValidFile) {
  ASSERT_TRUE(client_.create_scene("projects/default/scenes/empty"));
  ASSERT_EQ(run_program({"scene", "export", "empty", dir_.path("e.glb")}).exit, 0);
  EXPECT_NE(dir_.read("e.glb").find("\"version\":\"2.0\""), std::string::npos);
}

}  // namespace
}  // namespace sightline::tests
