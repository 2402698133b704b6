// Weights and interpolations that Assimp does not report, and poses of files that it reads.
#include "client/importer/assimp_omissions.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/importer/assimp_import.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

/// Collada's text with these weights, and a scene for which Assimp has reported others.
FileScene corrected(const std::string& listed, const std::vector<double>& reported,
                    const char* importer = "Collada Importer") {
  FileScene scene;
  scene.meshes.resize(1);
  scene.meshes[0].name = "face";
  scene.meshes[0].weights = reported;
  const std::string text =
      "<morph><source id='other'><float_array>1 0</float_array></source>"
      "<source id=\"w\"><float_array id=\"a\" count=\"2\">" +
      listed +
      "</float_array></source><targets><input semantic=\"MORPH_TARGET\" "
      "source=\"#other\"/><input source='#w' semantic=\"MORPH_WEIGHT\"/>"
      "</targets></morph>";
  correct_omissions(importer, text, scene);
  return scene;
}

using Weights = std::vector<double>;

TEST(Omissions, AWeightOfOneIsZeroUnlessTheFileHasOne) {
  const FileScene zero = corrected("0 0.5", {1, 0.5});
  EXPECT_EQ(zero.meshes[0].weights, (Weights{0, 0.5}));
  EXPECT_TRUE(zero.warnings.empty());
  const FileScene one = corrected("1 0.5", {1, 0.5});
  EXPECT_EQ(one.meshes[0].weights, (Weights{1, 0.5}));
  EXPECT_TRUE(one.warnings.empty());
}

TEST(Omissions, WeightsThatMayBeZeroOrOneAreWarnedAbout) {
  const FileScene both = corrected("0 1.0 0.5", {1, 1, 0.5});
  EXPECT_EQ(both.meshes[0].weights, (Weights{0, 0, 0.5}));
  ASSERT_EQ(both.warnings.size(), 1U);
  EXPECT_EQ(both.warnings[0].kind, "weights_unknown");
  EXPECT_EQ(both.warnings[0].count, 2U);
  EXPECT_EQ(both.warnings[0].first, "face");
  const FileScene fbx = corrected("", {1, 0.25}, "Autodesk FBX Importer");
  EXPECT_EQ(fbx.meshes[0].weights, (Weights{0, 0}));
  EXPECT_EQ(fbx.warnings.size(), 1U);
  EXPECT_TRUE(corrected("", {}, "Autodesk FBX Importer").warnings.empty());
}

std::vector<Warning> warnings_of(const std::string& words) {
  FileScene scene;
  scene.animations.resize(1);
  correct_omissions("Collada Importer",
                    "<source id=\"joints\"><Name_array>STEP</Name_array></source>"
                    "<source id=\"i\"><Name_array id=\"n\">" +
                        words +
                        "</Name_array></source><sampler><input semantic=\"INTERPOLATION\" "
                        "source=\"#i\"/></sampler>",
                    scene);
  return scene.warnings;
}

TEST(Omissions, InterpolationsAreWarnedAboutUnlessLinear) {
  EXPECT_TRUE(warnings_of("LINEAR LINEAR").empty());
  for (const char* name : {"STEP", "BEZIER", "HERMITE"}) {
    const auto warnings = warnings_of(std::string("LINEAR ") + name + " LINEAR");
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_EQ(warnings[0].first, name);
  }
  EXPECT_NE(warnings_of("STEP BEZIER").at(0).message.find("BEZIER, STEP"), std::string::npos);
}

TEST(Omissions, TextThatIsCutIsNoMatter) {
  FileScene scene;
  scene.animations.resize(1);
  for (const char* text :
       {"<input", "<input semantic=\"INTERPOLATION\" source=\"#\"/>", "<source",
        "<source id=\"a\"><Name_array>", "<source id='a", "<input source='#a'/>"})
    correct_omissions("Collada Importer", text, scene);
  EXPECT_TRUE(scene.warnings.empty());
}

std::vector<std::string> unread_in(const std::string& text) {
  FileScene scene;
  correct_omissions("Collada Importer", "<COLLADA>" + text + "</COLLADA>", scene);
  std::vector<std::string> kinds;
  for (const Warning& warning : scene.warnings) kinds.push_back(warning.kind + warning.first);
  return kinds;
}

TEST(Omissions, SurfacesThatAssimpDoesNotReadAreWarnedAbout) {
  using Kinds = std::vector<std::string>;
  EXPECT_EQ(unread_in("<asset><unit/></asset><geometry><mesh><source/><triangles/><extra><a/>"
                      "</extra></mesh></geometry><geometry><spline/></geometry>"),
            Kinds{});
  EXPECT_EQ(unread_in("<geometry><brep/></geometry>"), Kinds{"shapes_left_out<brep>"});
  EXPECT_EQ(unread_in("<geometry><convex_mesh><source/></convex_mesh></geometry>"),
            Kinds{"shapes_left_out<convex_mesh>"});
  EXPECT_EQ(unread_in("<geometry><mesh><quads/></mesh></geometry>"),
            Kinds{"shapes_left_out<quads>"});
  EXPECT_EQ(unread_in("<geometry><asset><unit meter=\"0.1\"/></asset></geometry>"),
            Kinds{"frame_of_part<unit>"});
}

// A strip that follows one joint, which is 5 above; its node is 10 away.
TEST(AssimpPoses, ASkinOfColladaLiesWhereItsJointsAre) {
  const tests::TempDir dir;
  const auto scene = import_scene(dir.write("skin.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_controllers><controller id="c"><skin source="#g">
<bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>
<source id="j"><Name_array id="ja" count="1">bone</Name_array><technique_common>
<accessor source="#ja" count="1" stride="1"><param name="JOINT" type="name"/></accessor></technique_common></source>
<source id="b"><float_array id="ba" count="16">1 0 0 0 0 1 0 0 0 0 1 -1 0 0 0 1</float_array><technique_common>
<accessor source="#ba" count="1" stride="16"><param name="TRANSFORM" type="float4x4"/></accessor></technique_common></source>
<source id="w"><float_array id="wa" count="1">1</float_array><technique_common>
<accessor source="#wa" count="1" stride="1"><param name="WEIGHT" type="float"/></accessor></technique_common></source>
<joints><input semantic="JOINT" source="#j"/><input semantic="INV_BIND_MATRIX" source="#b"/></joints>
<vertex_weights count="3"><input semantic="JOINT" source="#j" offset="0"/>
<input semantic="WEIGHT" source="#w" offset="1"/><vcount>1 1 1</vcount><v>0 0 0 0 0 0</v></vertex_weights>
</skin></controller></library_controllers>
<library_visual_scenes><visual_scene id="s">
<node id="bone" sid="bone" name="bone" type="JOINT"><translate>0 5 0</translate></node>
<node id="body" name="body"><translate>10 0 0</translate>
<instance_controller url="#c"><skeleton>#bone</skeleton></instance_controller></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)"));
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->meshes.size(), 1U);
  // In the frame of its node: 10 back, 5 up, and 1 down along z by the inverse bind matrix.
  EXPECT_EQ(scene->meshes[0].vertices,
            (std::vector<Vertex>{{-10, 5, -1}, {-9, 5, -1}, {-10, 6, -1}}));
}

}  // namespace
}  // namespace sightline::client::importer
