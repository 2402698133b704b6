// Scenes that no ray can hit, and what they are called.
#include "client/importer/hittable.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>

#include "client/importer/assimp_import.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

ImportedScene one_mesh(ImportedMesh mesh) {
  ImportedScene scene;
  scene.meshes.push_back(std::move(mesh));
  scene.nodes.emplace_back();
  scene.nodes[0].mesh = 0;
  return scene;
}

ImportedMesh triangle(const Vertex& a, const Vertex& b, const Vertex& c) {
  ImportedMesh mesh;
  mesh.vertices = {a, b, c};
  mesh.faces = {{0, 1, 2}};
  mesh.triangles = 1;
  return mesh;
}

bool says(const ImportedScene& scene, const std::string& words, const char* file = "a.ply") {
  const std::string why = why_not_hittable(scene, file);
  return why.find(words) != std::string::npos;
}

TEST(Hittable, OneTriangleIsEnough) {
  EXPECT_EQ(why_not_hittable(one_mesh(triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})), "a.obj"), "");
  EXPECT_EQ(why_not_hittable(one_mesh(triangle({0, 0, 0}, {1e-30F, 0, 0}, {0, 1e-30F, 0})), "a"),
            "");
}

TEST(Hittable, TrianglesThatAreNeverHitAreCounted) {
  EXPECT_TRUE(says(one_mesh(triangle({0, 0, 0}, {1, 1, 1}, {3, 3, 3})), "1 triangles has an area"));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(says(one_mesh(triangle({nan, 0, 0}, {1, 0, 0}, {0, 1, 0})), "not finite"));
  ImportedScene unused = one_mesh(triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  unused.nodes[0].mesh = kNone;
  EXPECT_TRUE(says(unused, "no node"));
}

TEST(Hittable, PointsAndLinesAreNamed) {
  ImportedMesh points;
  points.vertices = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_TRUE(says(one_mesh(points), "point cloud: 2 points"));
  points.faces = {{kNoVertex, kNoVertex, kNoVertex}, {kNoVertex, kNoVertex, kNoVertex}};
  points.lines_and_points = 2;
  EXPECT_TRUE(says(one_mesh(points), "point cloud: 2 points"));
  ImportedMesh line = points;
  line.faces.resize(1);
  line.lines_and_points = 1;
  EXPECT_TRUE(says(one_mesh(line), "1 lines and points"));
}

TEST(Hittable, EmptyFilesAreNamed) {
  EXPECT_TRUE(says({}, "empty STL", "Part.STL"));
  EXPECT_TRUE(says({}, "no triangles", "a.glb"));
}

TEST(Hittable, FilesAreNamedToo) {
  const tests::TempDir dir;
  const auto why = [&](const char* name, const std::string& text) {
    const std::string path = dir.write(name, text);
    const auto scene = import_scene(path);
    return scene ? why_not_hittable(*scene, path) : scene.error().message;
  };
  EXPECT_NE(why("cloud.ply",
                "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                "property float z\nend_header\n0 0 0\n1 0 0\n")
                .find("point cloud"),
            std::string::npos);
  EXPECT_NE(why("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n").find("point cloud"),
            std::string::npos);
  EXPECT_NE(why("empty.stl", "solid a\nendsolid a\n").find("empty STL"), std::string::npos);
  EXPECT_NE(why("binary.stl", std::string(84, '\0')).find("empty STL"), std::string::npos);
  EXPECT_NE(why("nodes.gltf", R"({"asset": {"version": "2.0"}, "scene": 0,
                                 "scenes": [{"nodes": [0]}], "nodes": [{"name": "a"}]})")
                .find("no triangles"),
            std::string::npos);
  EXPECT_NE(why("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n").find("lines"),
            std::string::npos);
  EXPECT_EQ(why("square.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "");
}

}  // namespace
}  // namespace sightline::client::importer
