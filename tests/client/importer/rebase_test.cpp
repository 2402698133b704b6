// Rebasing of far scenes: when it happens, and that it does not move anything.
#include "client/importer/rebase.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
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

std::vector<Warning> without_notes(const Rebased& rebased) {
  std::vector<Warning> warnings = rebased.warnings;
  std::erase_if(warnings, [](const Warning& warning) { return warning.is_note; });
  return warnings;
}

// The offset that all meshes have.
Offset rebase(Scene& scene) {
  const Rebased rebased = importer::rebase(scene.meshes, scene.nodes);
  EXPECT_EQ(rebased.offsets.size(), scene.meshes.size());
  for (const Offset& offset : rebased.offsets) EXPECT_EQ(offset, rebased.offsets[0]);
  EXPECT_TRUE(without_notes(rebased).empty());
  return rebased.offsets.empty() ? kNowhere : rebased.offsets[0];
}

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

TEST(Rebase, TheOffsetIsAMultipleOfTheExtentAsAPowerOfTwo) {
  Scene scene = scene_of({mesh_of({{1000, 0, -4000}, {1003, 1, -4000}, {1001, 2, -3998}})});
  EXPECT_EQ(rebase(scene), (Offset{1000, 0, -4000}));
  EXPECT_EQ(scene.meshes[0].vertices, (std::vector<Point>{{0, 0, 0}, {3, 1, 0}, {1, 2, 2}}));
  EXPECT_EQ(scene.nodes[0].parent_from_local, (Rows{1, 0, 0, 1000, 0, 1, 0, 0, 0, 0, 1, -4000}));
}

TEST(Rebase, KeepsWorldPositionsToTheLastBit) {
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

TEST(Rebase, AMeshOfSeveralNodesIsRebasedInEachOfThem) {
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

TEST(Rebase, RemovesATranslationThatUndidTheOffset) {
  Scene scene = scene_of({mesh_of({{4e6, 0, 0}, {4e6 + 1, 0, 0}, {4e6, 1, 0}})});
  scene.nodes[0].parent_from_local[3] = -4e6;
  rebase(scene);
  EXPECT_EQ(scene.nodes[0].parent_from_local, kIdentity);
}

TEST(Rebase, TouchingMeshesAndEqualMeshesStaySo) {
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

TEST(Rebase, NearScenesDoNotChange) {
  expect_untouched(scene_of({}));
  expect_untouched(scene_of({mesh_of({})}));
  expect_untouched(scene_of({mesh_of({{15, 15, 15}, {15.75, 15, 15}, {15, 15.5, 15}})}));
  // All vertices in one point: there is no extent to compare a distance with.
  expect_untouched(scene_of({mesh_of({{1e6, 1e6, 1e6}, {1e6, 1e6, 1e6}})}));
  // Far, but on both sides of the origin.
  expect_untouched(scene_of({mesh_of({{-1e6, 0, 0}, {1e6, 1, 0}, {1e6, 0, 1}})}));
}

TEST(Rebase, NonFiniteVerticesAreIgnoredAndKept) {
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

TEST(Rebase, NodesThatCannotBeMovedPreventTheRebase) {
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

TEST(Rebase, AFarFileIsRebasedAfterItsFrameIsConverted) {
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

// Where a vertex is in the scene, if its node has no parent and is not turned.
Point placed(const Scene& scene, std::uint32_t mesh, std::size_t vertex) {
  Point at{};
  for (std::size_t k = 0; k < 3; ++k) {
    at[k] = scene.meshes[mesh].vertices[vertex][k] + scene.nodes[mesh].parent_from_local[4 * k + 3];
  }
  return at;
}

void expect_floats(const Scene& scene) {
  for (const FileMesh& mesh : scene.meshes) {
    for (const Point& v : mesh.vertices) {
      for (const double x : v) EXPECT_EQ(static_cast<double>(static_cast<float>(x)), x);
    }
  }
}

double distance(const Point& a, const Point& b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

// Points of a square of this size, in millimeters.
std::vector<Point> surveyed(const Point& corner, double size, std::size_t n,
                            tests::Random& random) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < n; ++i) {
    Point p{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double extent = k < 2 ? size : size / 20;
      p[k] = std::round((corner[k] + random.uniform() * extent) * 1000) / 1000;
    }
    points.push_back(p);
  }
  return points;
}

constexpr Point kUtm{388096.37, 3948996.81, 41.25};
constexpr Point kUtmNorth{512345.678, 5412345.678, 812.125};
constexpr Point kEcef{3875432.101, 332001.909, 5029123.456};

TEST(Rebase, MillimetersOfASmallThingAreKept) {
  tests::Random random(2);
  for (const Point& corner : {kUtm, kUtmNorth, kEcef}) {
    for (const double size : {0.1, 3.0, 25.0, 400.0, 4000.0}) {
      const std::vector<Point> file = surveyed(corner, size, 100, random);
      Scene scene = scene_of({mesh_of(file)});
      const Rebased rebased = importer::rebase(scene.meshes, scene.nodes);
      EXPECT_TRUE(without_notes(rebased).empty()) << rebased.warnings[0].message;
      expect_floats(scene);
      for (std::size_t i = 0; i < file.size(); ++i)
        EXPECT_LT(distance(placed(scene, 0, i), file[i]), std::min(2e-4, 1e-4 * size)) << size;
    }
  }
}

// Tiles of one file and of two, of sizes that differ, and whatever else is in the file.
TEST(Rebase, SharedVerticesAreAtOnePosition) {
  tests::Random random(3);
  for (const Point& corner : {kUtm, kUtmNorth, kEcef}) {
    for (const double other : {20.0, 333.0, 1000.0, 3000.0}) {
      const std::vector<Point> seam = surveyed(corner, 18, 50, random);
      std::vector<Point> left = seam, right = seam;
      left.push_back({corner[0] + 500, corner[1], corner[2]});
      right.push_back({corner[0] - other, corner[1] + 7, corner[2] + 1});
      Scene together = scene_of({mesh_of(left), mesh_of(right)});
      Scene one = scene_of({mesh_of(left)}), two = scene_of({mesh_of(right)});
      Scene alone = scene_of({mesh_of(surveyed({0, 0, 0}, 1, 5, random)), mesh_of(right)});
      for (Scene* scene : {&together, &one, &two, &alone}) {
        EXPECT_TRUE(without_notes(importer::rebase(scene->meshes, scene->nodes)).empty());
        expect_floats(*scene);
      }
      for (std::size_t i = 0; i < seam.size(); ++i) {
        const Point at = placed(together, 0, i);
        EXPECT_EQ(placed(together, 1, i), at);
        EXPECT_EQ(placed(one, 0, i), at);
        EXPECT_EQ(placed(two, 0, i), at);
        EXPECT_EQ(placed(alone, 1, i), at);
      }
    }
  }
}

TEST(Rebase, MeshesFarFromEachOtherHaveOffsetsOfTheirOwn) {
  tests::Random random(4);
  const Point there{kUtm[0] + 50'000, kUtm[1] - 70'000, kUtm[2]};
  const std::vector<Point> here = surveyed(kUtm, 30, 50, random);
  const std::vector<Point> far = surveyed(there, 30, 50, random);
  Scene scene =
      scene_of({mesh_of(here), mesh_of(far), mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 0.1, 0}})});
  const Rebased rebased = importer::rebase(scene.meshes, scene.nodes);
  EXPECT_TRUE(without_notes(rebased).empty());
  EXPECT_NE(rebased.offsets[0], rebased.offsets[1]);
  EXPECT_EQ(rebased.offsets[2], kNowhere) << "a mark at the origin stays there";
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_LT(distance(placed(scene, 0, i), here[i]), 2e-4);
    EXPECT_LT(distance(placed(scene, 1, i), far[i]), 2e-4);
  }
  EXPECT_EQ(scene.meshes[2].vertices[2][1], static_cast<double>(0.1F));
}

TEST(Rebase, NearScenesAreRoundedToFloats) {
  tests::Random random(5);
  for (const double size : {1e-3, 1.0, 300.0, 1e6}) {
    const std::vector<Point> file = surveyed({-size / 3, size, 0}, size, 50, random);
    Scene scene = scene_of({mesh_of(file), mesh_of({file[0], file[1], file[2]})});
    EXPECT_EQ(rebase(scene), kNowhere);
    for (std::size_t i = 0; i < file.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_EQ(scene.meshes[0].vertices[i][k],
                  static_cast<double>(static_cast<float>(file[i][k])));
    }
  }
}

TEST(Rebase, VerticesWithoutAFaceDoNotCount) {
  FileMesh mesh =
      mesh_of({{0, 0, 0}, {5e5, 4e6, 1.1}, {500000.1, 4e6, 1.1}, {5e5, 4000000.1, 1.1}});
  mesh.faces = {{0, 3}, {1, 2, 3}};
  Scene scene = scene_of({mesh});
  EXPECT_TRUE(without_notes(importer::rebase(scene.meshes, scene.nodes)).empty());
  EXPECT_NEAR(placed(scene, 0, 2)[0] - placed(scene, 0, 1)[0], 0.1, 1e-5);
}

TEST(Rebase, ALossIsAWarning) {
  tests::Random random(6);
  // A box among tiles, a node that cannot be moved, and a mesh from the origin to here.
  Scene among = scene_of(
      {mesh_of(surveyed(kUtm, 3000, 50, random)), mesh_of(surveyed(kUtm, 0.1, 50, random))});
  const auto first = without_notes(importer::rebase(among.meshes, among.nodes));
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].kind, "precision");
  EXPECT_EQ(first[0].count, 1U);
  Scene below = scene_of({mesh_of(surveyed(kUtm, 10, 50, random)), mesh_of({{0, 0, 0.5}})});
  below.meshes[0].name = "roof";
  below.nodes[1].parent = 0;
  const auto second = without_notes(importer::rebase(below.meshes, below.nodes));
  ASSERT_EQ(second.size(), 1U);
  EXPECT_NE(second[0].message.find("mesh 'roof'"), std::string::npos) << second[0].message;
  EXPECT_NE(second[0].message.find("by up to 0.12"), std::string::npos) << second[0].message;
  Scene wide = scene_of({mesh_of({kUtm, {0, 0, 0}, {0.1, 0, 0}})});
  EXPECT_TRUE(without_notes(importer::rebase(wide.meshes, wide.nodes)).empty())
      << "small for its size";
}

TEST(Rebase, ASmallLossIsANote) {
  tests::Random random(8);
  const std::vector<Point> file = surveyed(kUtm, 5000, 50, random);
  Scene scene = scene_of({mesh_of(file)});
  const Rebased rebased = importer::rebase(scene.meshes, scene.nodes);
  ASSERT_EQ(rebased.warnings.size(), 1U);
  EXPECT_TRUE(rebased.warnings[0].is_note);
  EXPECT_EQ(rebased.warnings[0].kind, "rounded");
  double largest = 0;
  for (std::size_t i = 0; i < file.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      largest = std::max(largest, std::abs(placed(scene, 0, i)[k] - file[i][k]));
  EXPECT_NE(rebased.warnings[0].message.find(fmt::format("by up to {:.3g}", largest)),
            std::string::npos)
      << rebased.warnings[0].message << " and " << largest;
}

TEST(Rebase, AMeshThatTheLatticeDestroysGetsItsOwn) {
  tests::Random random(7);
  const std::vector<Point> box = surveyed(kUtm, 0.1, 50, random);
  Scene scene = scene_of({mesh_of({{0.1, 0, 0}, {6e6, 0, 0}, {0, 6e6, 0}}), mesh_of(box)});
  const auto warnings = without_notes(importer::rebase(scene.meshes, scene.nodes));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].kind, "several_lattices");
  for (std::size_t i = 0; i < box.size(); ++i)
    EXPECT_LT(distance(placed(scene, 1, i), box[i]), 1e-5);
}

// Beside a mesh of thousands of kilometers, others have one step of their own, or one each.
TEST(Rebase, SeveralLatticesAreAWarning) {
  tests::Random random(9);
  struct Case {
    std::vector<double> sizes;
    std::size_t own_steps;
  };
  const std::vector<Case> cases{
      {{200}, 0},     {{10}, 1},       {{1e-3}, 1},        {{10, 5}, 1},
      {{10, 0.1}, 1}, {{10, 1e-3}, 2}, {{200, 0.1, 5}, 1}, {{10, 1e-3, 1e-6}, 3}};
  for (const Point& corner : {kUtm, kUtmNorth, kEcef}) {
    for (const Case& c : cases) {
      Scene scene = scene_of({mesh_of({{0.1, 0, 0}, {6e6, 0, 0}, {0, 6e6, 0}, {0, 0, 6e6}})});
      for (const double size : c.sizes) {
        std::vector<Point> box;
        for (const double x : {0.0, size / 3, size})
          box.push_back({corner[0] + x, corner[1], corner[2] + x});
        scene.meshes.push_back(mesh_of(box));
        scene.nodes.push_back(
            {.name = "box", .mesh = static_cast<std::uint32_t>(scene.meshes.size() - 1)});
      }
      std::size_t own_steps = 0;
      for (const Warning& warning : importer::rebase(scene.meshes, scene.nodes).warnings)
        own_steps += warning.kind == "several_lattices" ? warning.count : 0;
      EXPECT_EQ(own_steps, c.own_steps) << c.sizes.front() << " and " << c.sizes.back();
    }
  }
}

TEST(Rebase, OtherFilesAreBroughtToOffsetsThatHoldThem) {
  tests::Random random(8);
  const std::vector<Point> file = surveyed(kUtm, 30, 50, random);
  Scene first = scene_of({mesh_of(file)});
  const Rebased rebased = importer::rebase(first.meshes, first.nodes);
  std::vector<Point> later = file;
  for (Point& p : later) p[0] = std::round((p[0] + 12.345) * 1000) / 1000;
  Scene second = scene_of({mesh_of(later)});
  const auto same = rebase_to(rebased.offsets, second.meshes, second.nodes);
  ASSERT_TRUE(same) << same.error().message;
  EXPECT_EQ(same->offsets, rebased.offsets);
  EXPECT_EQ(second.nodes[0].parent_from_local, first.nodes[0].parent_from_local);
  for (std::size_t i = 0; i < later.size(); ++i)
    EXPECT_LT(distance(placed(second, 0, i), later[i]), 2e-4);
  Scene near = scene_of({mesh_of(surveyed({0, 0, 0}, 30, 50, random))});
  EXPECT_FALSE(rebase_to(rebased.offsets, near.meshes, near.nodes));
}

}  // namespace
}  // namespace sightline::client::importer
