// Scene files as plain arrays: nothing is merged or lost, and numbers are kept.
#include "client/importer/assimp_import.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

using tests::TempDir;

// Two triangles, the second a repetition of the first, and a quad.
constexpr const char* kTwoObjects = R"(
v 0 0 0
v 1 0 0
v 0 1 0
v 1 1 0
o first
f 1 2 3
f 1 2 3
o second
f 1 2 4 3
)";

// One buffer of three vertices (0,0,0) (1,0,0) (0,1,0); the mesh has a triangle and a line, and two
// nodes share it.
constexpr const char* kGltf = R"({
  "asset": {"version": "2.0"},
  "scene": 0,
  "scenes": [{"nodes": [0]}],
  "nodes": [
    {"name": "root", "children": [1, 2], "translation": [10, 0, 0]},
    {"name": "left", "mesh": 0, "scale": [2, 2, 2]},
    {"name": "right", "mesh": 0, "translation": [0, 5, 0]}
  ],
  "meshes": [{"primitives": [
    {"attributes": {"POSITION": 0}, "mode": 4},
    {"attributes": {"POSITION": 0}, "mode": 2}
  ]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                 "min": [0, 0, 0], "max": [1, 1, 0]}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}],
  "buffers": [{"byteLength": 36,
    "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]
})";

std::vector<std::string> names_of(const ImportedScene& scene) {
  std::vector<std::string> names;
  for (const ImportedNode& node : scene.nodes) names.push_back(node.name);
  return names;
}

std::string error_of(const Result<ImportedScene>& scene) {
  return scene ? "" : scene.error().message;
}

TEST(AssimpImport, KeepsRepeatedFacesAndCutsQuads) {
  const TempDir dir;
  const auto scene = import_scene(dir.write("two.obj", kTwoObjects));
  ASSERT_TRUE(scene) << error_of(scene);
  ASSERT_EQ(scene->meshes.size(), 2U);
  EXPECT_EQ(scene->meshes[0].triangles, 2U);
  EXPECT_EQ(scene->meshes[1].triangles, 2U);
  ASSERT_EQ(scene->nodes.size(), 3U);
  EXPECT_EQ(scene->nodes[0].parent, kNone);
  EXPECT_EQ(scene->nodes[0].mesh, kNone);
  EXPECT_EQ(scene->nodes[1].name, "first");
  EXPECT_EQ(scene->nodes[1].parent, 0U);
  EXPECT_EQ(scene->nodes[1].mesh, 0U);
  EXPECT_EQ(scene->nodes[2].name, "second");
  EXPECT_EQ(scene->up_axis, UpAxis::kUnknown);
  EXPECT_EQ(scene->meters_per_unit, 0);
}

TEST(AssimpImport, ANodeOfSeveralMeshesGetsAChildForEach) {
  const TempDir dir;
  const auto scene = import_scene(dir.write("shared.gltf", kGltf));
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(names_of(*scene), (std::vector<std::string>{"root", "left", "left#0", "left#1", "right",
                                                        "right#0", "right#1"}));
  EXPECT_EQ(scene->nodes[1].mesh, kNone);
  EXPECT_EQ(scene->nodes[1].parent_from_local[0], 2);
  EXPECT_EQ(scene->nodes[2].parent, 1U);
  EXPECT_EQ(scene->nodes[2].parent_from_local, ImportedNode().parent_from_local);
  EXPECT_EQ(scene->nodes[4].parent, 0U);
  EXPECT_EQ(scene->nodes[4].parent_from_local[7], 5);
}

TEST(AssimpImport, AMeshOfSeveralNodesStaysOneMesh) {
  const TempDir dir;
  const auto scene = import_scene(dir.write("shared.gltf", kGltf));
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(scene->meshes.size(), 2U);
  EXPECT_EQ(scene->nodes[2].mesh, scene->nodes[5].mesh);
  EXPECT_EQ(scene->nodes[3].mesh, scene->nodes[6].mesh);
}

TEST(AssimpImport, LinesKeepTheirIndexAndAreNoTriangle) {
  const TempDir dir;
  const auto scene = import_scene(dir.write("shared.gltf", kGltf));
  ASSERT_TRUE(scene) << error_of(scene);
  const ImportedMesh& lines = scene->meshes[1];
  EXPECT_EQ(lines.triangles, 0U);
  EXPECT_EQ(lines.lines_and_points, lines.faces.size());
  EXPECT_GT(lines.lines_and_points, 0U);
  for (const Face& face : lines.faces) EXPECT_EQ(face, (Face{kNoVertex, kNoVertex, kNoVertex}));
}

TEST(AssimpImport, LinesAmongTrianglesDoNotShiftLaterIndices) {
  const TempDir dir;
  const auto scene = import_scene(dir.write("mixed.obj", R"(
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
o mixed
f 1 2 3
l 1 2
f 1 2 4
)"));
  ASSERT_TRUE(scene) << error_of(scene);
  ASSERT_EQ(scene->meshes.size(), 1U);
  const ImportedMesh& mesh = scene->meshes[0];
  ASSERT_EQ(mesh.faces.size(), 3U);
  EXPECT_NE(mesh.faces[0][0], kNoVertex);
  EXPECT_EQ(mesh.faces[1], (Face{kNoVertex, kNoVertex, kNoVertex}));
  EXPECT_EQ(mesh.vertices[mesh.faces[2][2]], (Vertex{0, 0, 1}));
  EXPECT_EQ(mesh.triangles, 2U);
  EXPECT_EQ(mesh.lines_and_points, 1U);
}

TEST(AssimpImport, KeepsNonFiniteVertices) {
  const TempDir dir;
  const auto scene = import_scene(dir.write("nan.ply", R"(ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
nan 1 0
3 0 1 2
)"));
  ASSERT_TRUE(scene) << error_of(scene);
  ASSERT_EQ(scene->meshes.size(), 1U);
  EXPECT_EQ(scene->meshes[0].triangles, 1U);
  EXPECT_NE(scene->meshes[0].vertices[2][0], scene->meshes[0].vertices[2][0]);
}

TEST(AssimpImport, TheFrameOfGltfIsRecordedAndConvertedOnRequest) {
  const TempDir dir;
  const std::string file = dir.write("shared.gltf", kGltf);
  const auto as_is = import_scene(file);
  ASSERT_TRUE(as_is) << error_of(as_is);
  EXPECT_EQ(as_is->up_axis, UpAxis::kY);
  EXPECT_EQ(as_is->meters_per_unit, 1);
  const auto converted = import_scene(file, {UpAxis::kZ, 0.5});
  ASSERT_TRUE(converted) << error_of(converted);
  EXPECT_EQ(converted->up_axis, UpAxis::kZ);
  EXPECT_EQ(converted->meters_per_unit, 0.5);
  EXPECT_EQ(converted->nodes[0].parent_from_local,
            (std::array<double, 12>{2, 0, 0, 20, 0, 0, -2, 0, 0, 2, 0, 0}));
  EXPECT_EQ(converted->nodes[1].parent_from_local, as_is->nodes[1].parent_from_local);
}

TEST(AssimpImport, ATransformIsKeptInDouble) {
  const TempDir dir;
  std::string gltf = kGltf;
  gltf.replace(gltf.find("[10, 0, 0]"), 10, "[5812345.001, 0, 1e39]");
  const auto scene = import_scene(dir.write("far.gltf", gltf));
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(scene->nodes[0].parent_from_local[3], 5812345.001);
  EXPECT_EQ(scene->nodes[0].parent_from_local[11], 1e39);
  gltf.replace(gltf.find("1e39"), 4, "1e309");
  EXPECT_NE(error_of(import_scene(dir.write("far.gltf", gltf))).find("1e309"), std::string::npos);
}

TEST(AssimpImport, ReportsTheFaultOfAFile) {
  const TempDir dir;
  EXPECT_NE(error_of(import_scene(dir.path("none.obj"))).find("No such file"), std::string::npos);
  EXPECT_NE(error_of(import_scene(dir.path(""))).find("is a directory"), std::string::npos);
  EXPECT_NE(error_of(import_scene(dir.write("broken.gltf", "{ this is no JSON"))), "");
  EXPECT_NE(error_of(import_scene(dir.write("empty.ply", ""))), "");
  EXPECT_NE(error_of(import_scene(dir.write("text.xyz", "hello"))), "");
}

// Assimp treats a face without corners as a polygon and fails to find it.
TEST(AssimpImport, AFaceWithoutCornersKeepsItsIndex) {
  const TempDir dir;
  const std::string text = R"(ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
0
)";
  const Face none{kNoVertex, kNoVertex, kNoVertex};
  const auto one = import_scene(dir.write("one.ply", text + "3 0 1 2\n"));
  ASSERT_TRUE(one) << error_of(one);
  EXPECT_EQ(one->meshes.at(0).faces, (std::vector<Face>{none, {0, 1, 2}}));
  EXPECT_EQ(one->meshes[0].triangles, 1u);
  const auto all = import_scene(dir.write("all.ply", text + "0\n"));
  ASSERT_TRUE(all) << error_of(all);
  EXPECT_EQ(all->meshes.at(0).faces, (std::vector<Face>{none, none}));
  EXPECT_EQ(all->meshes[0].triangles, 0u);
}

TEST(AssimpImport, RefusesAPolygonOfMissingVertices) {
  const TempDir dir;
  const auto scene = import_scene(dir.write("far.ply", R"(ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 0
0 1 0
4 0 1 2 2000000000
)"));
  EXPECT_NE(error_of(scene).find("face 0 names vertex 2000000000, but there are 4"),
            std::string::npos)
      << error_of(scene);
}

TEST(AssimpImport, AFileBeyondTheMemoryIsRefusedAtOnce) {
  const tests::TempDir dir;
  const std::string huge = dir.write("huge.obj", "v 0 0 0\n");
  std::filesystem::resize_file(huge, std::uintmax_t{1} << 42U);  // it takes no space
  EXPECT_EQ(check_readable(huge).error().code, Code::kResourceExhausted);
}

TEST(AssimpImport, RefusesAnInvalidUnit) {
  const TempDir dir;
  const std::string file = dir.write("two.obj", kTwoObjects);
  EXPECT_FALSE(import_scene(file, {{}, 0.0}));
  EXPECT_FALSE(import_scene(file, {{}, -1.0}));
}

TEST(AssimpImport, ProgressNeverDecreases) {
  const TempDir dir;
  double last = 0;
  const auto scene = import_scene(dir.write("two.obj", kTwoObjects), {}, [&](double part) {
    EXPECT_GE(part, last);
    EXPECT_LE(part, 1);
    last = part;
  });
  EXPECT_TRUE(scene) << error_of(scene);
}

}  // namespace
}  // namespace sightline::client::importer
