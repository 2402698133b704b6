// Losses of nodes and of vertices, held against the size of meshes.
#include "client/importer/float_losses.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/importer/assimp_import.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

// A root that is ten times as large, and a node with a triangle of this size at this place.
FileScene scene_of(double at, double size) {
  FileScene scene;
  FileMesh mesh;
  mesh.vertices = {{at, 0, 0}, {at + size, 0, 0}, {at, size, 0}};
  mesh.faces.corners = {0, 1, 2};
  mesh.faces.first = {0, 3};
  scene.meshes.push_back(mesh);
  scene.nodes.push_back({"root", kNone, {10, 0, 0, 0, 0, 10, 0, 0, 0, 0, 10, 0}, {}});
  scene.nodes.push_back({"part", 0, kIdentity, {0}});
  return scene;
}

std::string warning_of(FileScene scene, double of_root, double of_part) {
  warn_of_float_losses(
      [&](const FileNode& node) { return node.name == "root" ? of_root : of_part; }, scene);
  return scene.warnings.empty() ? "" : scene.warnings[0].message;
}

TEST(FloatLosses, SmallOnesAreSilent) {
  EXPECT_EQ(warning_of(scene_of(0, 1), 0, 0), "");
  EXPECT_EQ(warning_of(scene_of(1000, 1), 0, 0), "");
  EXPECT_EQ(warning_of(scene_of(0, 1), 5e-4, 4e-5), "");
  EXPECT_EQ(warning_of(scene_of(0, 100), 5e-2, 4e-3), "");
}

TEST(FloatLosses, LargeOnesAreWarnedAbout) {
  EXPECT_NE(warning_of(scene_of(0, 1), 2e-3, 0), "") << "of the root";
  EXPECT_NE(warning_of(scene_of(0, 1), 0, 2e-4), "") << "of the node";
  EXPECT_NE(warning_of(scene_of(3e6, 1), 0, 0), "") << "of the vertices";
  EXPECT_NE(warning_of(scene_of(0, 1), 0, 0.5)
                .find("node 'part', which is 10 units in size, is moved by up to 5"),
            std::string::npos);
}

TEST(FloatLosses, AnImportSaysThem) {
  const tests::TempDir folder;
  const auto scene = import_scene(folder.write("a.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node id="n"><translate>4294967294 0 0</translate>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>)"));
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_FALSE(scene->warnings.empty());
  EXPECT_EQ(scene->warnings[0].kind, "precision");
  EXPECT_EQ(scene->warnings[0].first, "node 'n'");
}

}  // namespace
}  // namespace sightline::client::importer
