// sightline scene import: files that no ray can hit, and scenes that are replaced.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/client/support/relay.h"
#include "tests/client/support/run_program.h"

namespace sightline::client::cli::verbs {
namespace {

using nlohmann::json;
using tests::run_program;

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

using Import = tests::LiveProgram;

TEST_F(Import, AFileThatNoRayCanHitIsAnErrorUnlessItIsAllowed) {
  const std::string points = dir_.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n");
  const auto refused = run_program({"scene", "import", "points", points});
  EXPECT_EQ(refused.exit, 1);
  EXPECT_TRUE(contains(refused.err, points + ": no ray can hit it: it is a point cloud"))
      << refused.err;
  EXPECT_TRUE(contains(refused.err, "--allow-empty"));
  EXPECT_EQ(run_program({"scene", "show", "points"}).exit, 3);
  const auto allowed =
      run_program({"scene", "import", "points", points, "--allow-empty", "--json"});
  ASSERT_EQ(allowed.exit, 0) << allowed.err;
  EXPECT_TRUE(contains(allowed.err, "point cloud"));
  EXPECT_EQ(json::parse(allowed.out)["warnings"].size(), 1U);
}

TEST_F(Import, EmptyStlAndUtf16AreNamed) {
  const std::string stl = dir_.write("empty.stl", "solid a\nendsolid a\n");
  EXPECT_TRUE(contains(run_program({"scene", "import", "a", stl}).err, "empty STL file"));
  std::string wide = "\xff\xfe";
  for (const char c : std::string(kTriangle)) wide += std::string(1, c) + '\0';
  const std::string obj = dir_.write("wide.obj", wide);
  const auto refused = run_program({"scene", "import", "a", obj});
  EXPECT_EQ(refused.exit, 1);
  EXPECT_TRUE(contains(refused.err, "UTF-16")) << refused.err;
}

TEST_F(Import, ARefusedFileLeavesTheSceneThatItWasToReplace) {
  const std::string triangle = dir_.write("triangle.obj", kTriangle);
  ASSERT_EQ(run_program({"scene", "import", "s", triangle}).exit, 0);
  const std::string empty = dir_.write("empty.stl", "solid a\nendsolid a\n");
  EXPECT_EQ(run_program({"scene", "import", "s", empty, "--replace"}).exit, 1);
  EXPECT_EQ(json::parse(run_program({"scene", "show", "s", "--json"}).out)["triangles_unique"], 1);
}

TEST_F(Import, ALostConnectionLeavesNothing) {
  std::string many;
  for (int i = 0; i < 4000; ++i) many += "o part" + std::to_string(i) + "\n" + kTriangle;
  // Each object has vertices of its own; faces name them from the end.
  for (std::size_t at = many.find("f 1 2 3"); at != std::string::npos; at = many.find("f 1 2 3"))
    many.replace(at, 7, "f -3 -2 -1");
  const std::string file = dir_.write("many.obj", many);
  ASSERT_EQ(run_program({"scene", "import", "whole", file}).exit, 0);
  tests::Relay relay(server_->port());
  relay.cut_each_after(400'000, 0);  // the meshes are there; what breaks is the list of nodes
  const auto cut = run_program({"scene", "import", "cut", file, "--endpoint", relay.endpoint()});
  EXPECT_EQ(cut.exit, 5) << cut.err;
  EXPECT_EQ(run_program({"scene", "show", "cut"}).exit, 3);
  EXPECT_EQ(run_program({"scene", "import", "cut", file}).exit, 0);
}

constexpr const char* kCollada = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 0 1</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";

TEST_F(Import, TurnedAxesAreReportedAndMayBeKept) {
  const std::string file = dir_.write("z.dae", kCollada);
  const auto bounds = [] {
    return json::parse(run_program({"scene", "show", "s", "--json"}).out)["bounds"];
  };
  const auto turned = run_program({"scene", "import", "s", file});
  ASSERT_EQ(turned.exit, 0) << turned.err;
  EXPECT_TRUE(contains(turned.err, "z axis is up")) << turned.err;
  EXPECT_TRUE(contains(turned.err, "--up z")) << turned.err;
  EXPECT_NEAR(bounds()[4].get<double>(), 1, 1e-5) << "y";
  const auto kept = run_program({"scene", "import", "s", file, "--replace", "--up", "z"});
  ASSERT_EQ(kept.exit, 0);
  EXPECT_EQ(kept.err, "");
  EXPECT_NEAR(bounds()[5].get<double>(), 1, 1e-5) << "z";
}

}  // namespace
}  // namespace sightline::client::cli::verbs
