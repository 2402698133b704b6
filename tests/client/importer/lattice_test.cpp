// Rebasing of far scenes: when it happens, and that it does not move anything.
#include "client/importer/lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "client/importer/assimp_import.h"
#include "client/importer/file_scene.h"
#include "tests/client/support/temp_dir.h"
#include "tests/support/random.h"

namespace sightline::client::importer {
namespace {

using Offset = std::array<double, 3>;
using Rows = std::array<double, 12>;

constexpr Rows kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
constexpr Offset kNowhere{};

struct Scene {
  std::vector<FileMesh> meshes;
  std::vector<ImportedNode> nodes;
};

Offset rebase(Scene& scene) { return importer::rebase(scene.meshes, scene.nodes); }

FileMesh mesh_of(std::vector<Point> vertices) {
  FileMesh mesh;
  mesh.vertices = std::move(vertices);
  return mesh;
}

// One node for each mesh, without a parent.
Scene scene_of(std::vector<FileMesh> meshes) {
  Scene scene;
  scene.meshes = std::move(meshes);
  for (std::uint32_t i = 0; i < scene.meshes.size(); ++i)
    scene.nodes.push_back({.name = std::to_string(i), .mesh = i});
  return scene;
}

// All coordinates are floats.
std::vector<Point> scattered(const Offset& middle, double extent, std::size_t n,
                             tests::Random& random) {
  std::vector<float> floats(3 * n);
  for (std::size_t i = 0; i < floats.size(); ++i)
    floats[i] = static_cast<float>(middle[i % 3] + random.uniform(-extent / 2, extent / 2));
  std::vector<Point> vertices(n);
  for (std::size_t i = 0; i < floats.size(); ++i)
    vertices[i / 3][i % 3] = static_cast<double>(floats[i]);
  return vertices;
}

bool same(const Scene& a, const Scene& b) {
  if (a.nodes.size() != b.nodes.size() || a.meshes.size() != b.meshes.size()) return false;
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    if (a.nodes[i].parent_from_local != b.nodes[i].parent_from_local) return false;
  }
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    if (a.meshes[i].vertices != b.meshes[i].vertices) return false;
  }
  return true;
}

void expect_untouched(const Scene& scene) {
  Scene after = scene;
  EXPECT_EQ(rebase(after), kNowhere);
  EXPECT_TRUE(same(scene, after));
}

TEST(Lattice, TheOffsetIsAMultipleOfTheExtentAsAPowerOfTwo) {
  Scene scene = scene_of({mesh_of({{1000, 0, -4000}, {1003, 1, -4000}, {1001, 2, -3998}})});
  EXPECT_EQ(rebase(scene), (Offset{1000, 0, -4000}));
  EXPECT_EQ(scene.meshes[0].vertices, (std::vector<Point>{{0, 0, 0}, {3, 1, 0}, {1, 2, 2}}));
  EXPECT_EQ(scene.nodes[0].parent_from_local, (Rows{1, 0, 0, 1000, 0, 1, 0, 0, 0, 0, 1, -4000}));
}

TEST(Lattice, KeepsWorldPositionsToTheLastBit) {
  tests::Random random(1);
  int rebased = 0;
  for (int round = 0; round < 2000; ++round) {
    const double extent = std::exp2(random.uniform(-60, 60));
    Offset middle{};
    for (double& x : middle)
      x = extent * std::exp2(random.uniform(-3, 30)) * (random.below(2) ? 1 : -1);
    const Scene before = scene_of({mesh_of(scattered(middle, extent, 40, random)),
                                   mesh_of(scattered(middle, extent, 40, random))});
    Scene after = before;
    const Offset offset = rebase(after);
    rebased += offset != kNowhere;
    for (std::size_t m = 0; m < before.meshes.size(); ++m) {
      for (std::size_t i = 0; i < before.meshes[m].vertices.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          const double was = before.meshes[m].vertices[i][k];
          const double is = after.meshes[m].vertices[i][k];
          ASSERT_EQ(was - offset[k], is) << "round " << round;
          ASSERT_EQ(is + offset[k], was) << "round " << round;
        }
      }
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_EQ(after.nodes[m].parent_from_local[4 * k + 3], offset[k]);
    }
  }
  EXPECT_GT(rebased, 1000);
}

TEST(Lattice, AMeshOfSeveralNodesIsRebasedInEachOfThem) {
  Scene scene = scene_of({mesh_of({{4096, 0, 0}, {4097, 0, 0}, {4096, 1, 0}})});
  scene.nodes = {{.name = "root", .parent_from_local = {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0}},
                 {.name = "still", .parent = 0, .mesh = 0},
                 {.name = "turned",
                  .parent = 0,
                  .parent_from_local = {0, -2, 0, 7, 2, 0, 0, 8, 0, 0, -2, 9},
                  .mesh = 0}};
  EXPECT_EQ(rebase(scene), (Offset{4096, 0, 0}));
  EXPECT_EQ(scene.nodes[0].parent_from_local[3], 5);
  EXPECT_EQ(scene.nodes[1].parent_from_local, (Rows{1, 0, 0, 4096, 0, 1, 0, 0, 0, 0, 1, 0}));
  EXPECT_EQ(scene.nodes[2].parent_from_local, (Rows{0, -2, 0, 7, 2, 0, 0, 8200, 0, 0, -2, 9}));
}

TEST(Lattice, RemovesATranslationThatUndidTheOffset) {
  Scene scene = scene_of({mesh_of({{4e6, 0, 0}, {4e6 + 1, 0, 0}, {4e6, 1, 0}})});
  scene.nodes[0].parent_from_local[3] = -4e6;
  rebase(scene);
  EXPECT_EQ(scene.nodes[0].parent_from_local, kIdentity);
}

TEST(Lattice, TouchingMeshesAndEqualMeshesStaySo) {
  const std::vector<Point> left{{5000.25, 0, 0}, {5001.5, 0, 0}, {5001.5, 1, 0}};
  const std::vector<Point> right{{5001.5, 0, 0}, {5002.75, 0, 0}, {5001.5, 1, 0}};
  // A copy of the first, moved: a different mesh before and after.
  const std::vector<Point> moved{{5002.25, 0, 0}, {5003.5, 0, 0}, {5003.5, 1, 0}};
  Scene scene = scene_of({mesh_of(left), mesh_of(right), mesh_of(moved), mesh_of(left)});
  EXPECT_NE(rebase(scene), kNowhere);
  EXPECT_EQ(scene.meshes[0].vertices[1], scene.meshes[1].vertices[0]);
  EXPECT_EQ(scene.meshes[0].vertices[2], scene.meshes[1].vertices[2]);
  EXPECT_EQ(scene.meshes[0].vertices, scene.meshes[3].vertices);
  EXPECT_NE(scene.meshes[0].vertices, scene.meshes[2].vertices);
  for (const ImportedNode& node : scene.nodes)
    EXPECT_EQ(node.parent_from_local, scene.nodes[0].parent_from_local);
}

TEST(Lattice, NearScenesDoNotChange) {
  expect_untouched(scene_of({}));
  expect_untouched(scene_of({mesh_of({})}));
  expect_untouched(scene_of({mesh_of({{15, 15, 15}, {15.75, 15, 15}, {15, 15.5, 15}})}));
  // All vertices in one point: there is no extent to compare a distance with.
  expect_untouched(scene_of({mesh_of({{1e6, 1e6, 1e6}, {1e6, 1e6, 1e6}})}));
  // Far, but on both sides of the origin.
  expect_untouched(scene_of({mesh_of({{-1e6, 0, 0}, {1e6, 1, 0}, {1e6, 0, 1}})}));
}

TEST(Lattice, NonFiniteVerticesAreIgnoredAndKept) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  Scene scene =
      scene_of({mesh_of({{1024, 0, 0}, {1025, 0, 0}, {1024, 1, 0}, {nan, 1, 0}, {1024, -inf, 0}})});
  EXPECT_EQ(rebase(scene), (Offset{1024, 0, 0}));
  EXPECT_EQ(scene.meshes[0].vertices[1], (Point{1, 0, 0}));
  EXPECT_TRUE(std::isnan(scene.meshes[0].vertices[3][0]));
  EXPECT_EQ(scene.meshes[0].vertices[4], (Point{1024, -inf, 0}));
  Scene none = scene_of({mesh_of({{nan, nan, nan}, {inf, inf, inf}})});
  EXPECT_EQ(rebase(none), kNowhere);
}

TEST(Lattice, NodesThatCannotBeMovedPreventTheRebase) {
  const auto far = mesh_of({{4096, 0, 0}, {4097, 0, 0}, {4096, 1, 0}});
  Scene scene = scene_of({far, far});
  scene.nodes[1].parent = 0;  // It would move with the node above it
  expect_untouched(scene);
  scene = scene_of({far, far});
  scene.nodes[1].parent_from_local[3] = 1e-15;  // 4096 and this need more bits than a double has
  expect_untouched(scene);
  scene.nodes[1].parent_from_local = {1e-300, 0, 0, 0, 0, 1e-300, 0, 0, 0, 0, 1.0 / 3, 0};
  EXPECT_NE(rebase(scene), kNowhere) << "a power of two times any number is exact";
  scene = scene_of({mesh_of({{12288, 0, 0}, {12289, 0, 0}, {12288, 1, 0}})});
  scene.nodes[0].parent_from_local[0] = 1.0 / 3;  // Three times this is one bit too long
  expect_untouched(scene);
}

TEST(Lattice, AFarFileIsRebasedAfterItsFrameIsConverted) {
  const tests::TempDir dir;
  const auto scene = import_scene(dir.write("far.obj", R"(
v 500000 4000000 10
v 500001 4000000 10
v 500000 4000001 10.5
o first
f 1 2 3
o second
f 3 2 1
)"));
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->nodes.size(), 3U);
  EXPECT_EQ(scene->nodes[0].parent_from_local, kIdentity);
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_EQ(scene->nodes[i].parent_from_local,
              (Rows{1, 0, 0, 500000, 0, 1, 0, 4000000, 0, 0, 1, 0}));
  }
  EXPECT_EQ(scene->meshes[0].vertices[2], (Vertex{0, 1, 10.5f}));
}

}  // namespace
}  // namespace sightline::client::importer
