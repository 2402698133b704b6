// The oracle for closest points against formulas, and its bounds against exact distances.
#include "tests/support/brute_nearest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenegraph/scene.h"
#include "tests/support/hard_points.h"
#include "tests/support/random.h"
#include "tests/support/rational_distance.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;

constexpr double kAnyDistance = std::numeric_limits<double>::infinity();

// Without bounds and boxes: the exact distance of every face.
std::vector<NearFace> every_distance(const std::vector<PlacedMesh>& meshes, const Vec3d& p) {
  std::vector<NearFace> faces;
  for (const PlacedMesh& placed : meshes) {
    for (std::uint32_t f = 0; f < placed.mesh.faces.size(); ++f) {
      const accel::geometry::Face& index = placed.mesh.faces[f];
      const auto& v = placed.mesh.vertices;
      const double distance =
          rational_distance(p, placed.world_from_local.m, v[index[0]], v[index[1]], v[index[2]]);
      faces.push_back({distance, placed.node, f});
    }
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

// All kinds, with limits at the distances themselves and just below.
void expect_exact(const BruteNearest& oracle, const std::vector<PlacedMesh>& meshes,
                  const Vec3d& p) {
  const std::vector<NearFace> all = every_distance(meshes, p);
  ASSERT_EQ(oracle.all(p, kAnyDistance), all);
  ASSERT_EQ(oracle.count(p, kAnyDistance), all.size());
  const auto farther = std::find_if(all.begin(), all.end(), [&](const NearFace& face) {
    return face.distance > all[0].distance;
  });
  ASSERT_EQ(oracle.all_closest(p, kAnyDistance), std::vector<NearFace>(all.begin(), farther));
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}, all.size() / 3, all.size() - 1}) {
    ASSERT_EQ(oracle.all(p, kAnyDistance, k + 1),
              std::vector<NearFace>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(k + 1)));
    const double limit = all[k].distance;
    for (const double d : {limit, std::nextafter(limit, -1.0)}) {
      const auto within = std::count_if(all.begin(), all.end(),
                                        [&](const NearFace& face) { return face.distance <= d; });
      ASSERT_EQ(oracle.count(p, d), static_cast<std::uint64_t>(within));
      ASSERT_EQ(oracle.all(p, d).size(), static_cast<std::size_t>(within));
      ASSERT_EQ(oracle.closest(p, d), within > 0 ? std::optional(all[0]) : std::nullopt);
    }
  }
}

// Rotated by angles that are no fractions of a turn, scaled along an axis, moved.
Affine sheared(double ratio, double offset) {
  const Vec3d x{2.0 / 3, -1.0 / 3, 2.0 / 3}, y{0.6, 0.8, 0.1}, z{-0.3, 0.5, 0.7};
  return {{ratio * x.x, y.x, z.x, offset, ratio * x.y, y.y, z.y, -offset, ratio * x.z, y.z, z.z,
           offset / 3}};
}

std::shared_ptr<const scenegraph::revision::Snapshot> scene_of(
    const std::vector<std::pair<TestMesh, Affine>>& parts) {
  std::vector<scenegraph::model::Update> updates;
  for (const auto& [mesh, affine] : parts) {
    scenegraph::model::PutNode put;
    put.node = -1 - static_cast<scenegraph::model::NodeRef>(updates.size());
    put.parent_from_local = affine;
    put.mesh = *scenegraph::model::Mesh::make(mesh.vertices, mesh.faces);
    updates.emplace_back(std::move(put));
  }
  scenegraph::Scene scene;
  EXPECT_TRUE(scene.apply(updates).ok());
  return scene.snapshot();
}

TEST(BruteNearest, OneFaceByFormula) {
  const TestMesh mesh = single_triangle();
  const BruteNearest oracle({{.mesh = mesh.view(), .node = 4}});
  EXPECT_EQ(oracle.closest({0.25, 0.25, 3}, kAnyDistance), (NearFace{3, 4, 0}));
  EXPECT_EQ(oracle.closest({0.25, -3, 4}, kAnyDistance), (NearFace{5, 4, 0}));
  EXPECT_EQ(oracle.closest({-2, -3, 6}, kAnyDistance), (NearFace{7, 4, 0}));
  EXPECT_EQ(oracle.closest({1, 1, 0}, kAnyDistance), (NearFace{std::sqrt(0.5), 4, 0}));
  EXPECT_EQ(oracle.closest({0.25, 0.25, 0}, 0), (NearFace{0, 4, 0}));
  EXPECT_EQ(oracle.closest({0.25, 0.25, 3}, 3), (NearFace{3, 4, 0}));
  EXPECT_EQ(oracle.closest({0.25, 0.25, 3}, std::nextafter(3, 0)), std::nullopt);
  EXPECT_EQ(oracle.closest({0.25, 0.25, 0}, -1), std::nullopt);
  EXPECT_EQ(oracle.count({0.25, 0.25, 0}, -kAnyDistance), 0u);
  EXPECT_TRUE(oracle.all({0.25, 0.25, 3}, kAnyDistance, 0).empty());
}

TEST(BruteNearest, TiesGoToTheLeastNodeThenPrimitive) {
  const TestMesh mesh = duplicates(70), one = single_triangle();
  const BruteNearest oracle(
      {{.mesh = mesh.view(), .node = 7}, {.mesh = one.view(), .node = 3}, {mesh.view(), {}, 5}});
  const std::vector<NearFace> all = oracle.all({0.25, 0.25, 1}, 1);
  ASSERT_EQ(all.size(), 141u);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
  EXPECT_EQ(all[0], (NearFace{1, 3, 0}));
  EXPECT_EQ(all[1], (NearFace{1, 5, 0}));
  EXPECT_EQ(all[140], (NearFace{1, 7, 69}));
  EXPECT_EQ(oracle.closest({0.25, 0.25, 1}, 1), all[0]);
  EXPECT_EQ(oracle.all({0.25, 0.25, 1}, 2, 72).back(), (NearFace{1, 7, 0}));
  EXPECT_EQ(oracle.count({0.25, 0.25, 1}, 1), 141u);
  // The center of a cube has all faces at the same distance.
  const TestMesh sides = cube();
  const BruteNearest around({{.mesh = sides.view()}});
  EXPECT_EQ(around.count({0, 0, 0}, 1), 12u);
  EXPECT_EQ(around.closest({0, 0, 0}, 1), (NearFace{1, 1, 0}));
}

TEST(BruteNearest, MasksAndNodesHideInstances) {
  const TestMesh mesh = single_triangle();
  const BruteNearest oracle({{.mesh = mesh.view(), .node = 1, .mask = 0b01},
                             {.mesh = mesh.view(), .node = 2, .mask = 0b10}});
  const Vec3d p{0, 0, 1};
  EXPECT_EQ(oracle.closest(p, 2, {.mask = 0b10})->node, 2u);
  EXPECT_EQ(oracle.closest(p, 2, {.mask = 0b11})->node, 1u);
  EXPECT_EQ(oracle.closest(p, 2, {.mask = 0b100}), std::nullopt);
  const NodeFilter second{.accepts = [](std::uint64_t node) { return node == 2; }};
  EXPECT_EQ(oracle.closest(p, 2, second)->node, 2u);
  EXPECT_EQ(oracle.count(p, 2, second), 1u);
}

TEST(BruteNearest, FacesWithoutAreaExistAndIncompleteOnesDoNot) {
  TestMesh mesh = single_triangle();
  mesh.vertices.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
  mesh.vertices.push_back({-std::numeric_limits<float>::infinity(), 0, 0});
  constexpr std::uint32_t kNone = accel::geometry::kNoVertex;
  mesh.faces = {{0, 1, 3}, {kNone, kNone, kNone}, {4, 1, 2}, {1, 1, 1}, {1, 2, 2}, {0, 1, 2}};
  const BruteNearest oracle({{.mesh = mesh.view()}});
  const std::vector<NearFace> found = oracle.all({0.25, 0, 0.25}, kAnyDistance);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0], (NearFace{0.25, 1, 5}));
  EXPECT_EQ(found[1].primitive, 4u);
  EXPECT_EQ(found[2], (NearFace{std::sqrt(0.625), 1, 3}));
}

TEST(BruteNearest, WalksTheSnapshotsHierarchyWithoutFlatNodes) {
  const TestMesh mesh = single_triangle();
  const Affine flat{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}};
  const Affine up{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2}};
  const BruteNearest oracle(scene_of({{mesh, flat}, {mesh, up}}));
  const auto nearest = oracle.closest({0.25, 0.25, -1}, kAnyDistance);
  ASSERT_TRUE(nearest.has_value());
  EXPECT_EQ(nearest->distance, 3);
  EXPECT_EQ(oracle.count({0.25, 0.25, -1}, kAnyDistance), 1u);
}

TEST(BruteNearest, SoupsAreExactInAnyFrame) {
  const TestMesh soup = random_soup(70, 0.3, 5);
  Random random(6);
  for (const Affine& affine : {Affine{}, sheared(1e6, 0), sheared(-1, 1e7), sheared(-1e-6, 3)}) {
    const std::vector<PlacedMesh> meshes{{soup.view(), affine, 2}};
    const BruteNearest oracle(meshes);
    for (int round = 0; round < 6; ++round) {
      const Vec3d local{random.uniform(-1, 2), random.uniform(-1, 2), random.uniform(0, 1)};
      expect_exact(oracle, meshes, affine.point(local));
      const Vec3d vertex = affine.point(Vec3d(soup.vertices[random.below(210)]));
      expect_exact(oracle, meshes, vertex);
      // World coordinates in doubles are off by as much as this.
      expect_exact(oracle, meshes, vertex + random.direction() * (1e-16 * length(vertex)));
    }
  }
}

// Rounded world coordinates, and boxes of them, are farther from the point than its exact distance.
TEST(BruteNearest, BoxesAllowForRoundedCorners) {
  Random random(10);
  const Affine far = sheared(1.5, 1e7);
  for (int round = 0; round < 200; ++round) {
    const TestMesh mesh{{Vec3f(random.direction())}, {{0, 0, 0}}};
    const std::vector<PlacedMesh> meshes{{mesh.view(), far, 2}};
    const BruteNearest oracle(meshes);
    const Vec3d p = far.point(Vec3d(mesh.vertices[0])) + random.direction() * 4e-9;
    const double distance = every_distance(meshes, p)[0].distance;
    ASSERT_EQ(oracle.closest(p, distance), (NearFace{distance, 2, 0}));
    ASSERT_EQ(oracle.count(p, std::nextafter(distance, 0)), 0u);
  }
}

TEST(BruteNearest, TinyScenesAreExact) {
  TestMesh soup = random_soup(40, 0.3, 7);
  for (Vec3f& v : soup.vertices) v = Vec3f(Vec3d(v) * 1e-38);
  Affine tiny;
  for (const std::size_t i : {0u, 5u, 10u}) tiny.m[i] = 0x1p-1000;
  const std::vector<PlacedMesh> meshes{{soup.view(), {}, 1}, {soup.view(), tiny, 2}};
  const BruteNearest oracle(meshes);
  for (const Vec3d& p : {Vec3d{}, Vec3d{1e-38, 5e-39, 0}, Vec3d{1e-60, 0, 1e-80}, Vec3d{1, 2, 3}}) {
    expect_exact(oracle, meshes, p);
  }
}

TEST(BruteNearest, HardPointsAreExact) {
  TestMesh needles = random_soup(20, 0.5, 8);
  for (Vec3f& v : needles.vertices) v.x *= 1e8f;
  const auto snapshot = scene_of({{icosphere(1), {}},
                                  {cube(), sheared(-2, 1e7)},
                                  {needles, sheared(1, -5)},
                                  {icosphere(1), sheared(1e6, 3)}});
  const std::vector<PlacedMesh> meshes = placed_meshes(*snapshot);
  const BruteNearest oracle(snapshot);
  const std::vector<Vec3d> points = hard_points(*snapshot, 1, 6 * kHardPointKinds);
  ASSERT_EQ(points.size(), 6 * kHardPointKinds);
  EXPECT_EQ(points, hard_points(*snapshot, 1, points.size()));
  const auto nearest = oracle.closest(points, kAnyDistance);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_TRUE(is_finite(points[i]));
    ASSERT_EQ(nearest[i], every_distance(meshes, points[i])[0]) << "kind " << i % kHardPointKinds;
  }
}

TEST(BruteNearest, SphereIsAsFarAsItsRadius) {
  const TestMesh sphere = icosphere(5);
  const BruteNearest oracle({{.mesh = sphere.view()}});
  Random random(11);
  std::vector<Vec3d> points{{0, 0, 0}};
  while (points.size() < 500) points.push_back(random.direction() * random.uniform(0, 3));
  const auto nearest = oracle.closest(points, kAnyDistance);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_NEAR(nearest[i]->distance, std::abs(length(points[i]) - 1), 2e-3);
    ASSERT_EQ(nearest[i], oracle.closest(points[i], kAnyDistance));
    ASSERT_EQ(
        nearest[i]->distance,
        every_distance({{TestMesh{sphere.vertices, {sphere.faces[nearest[i]->primitive]}}.view()}},
                       points[i])[0]
            .distance);
  }
  EXPECT_EQ(oracle.count(points[0], 0.5), 0u);
  EXPECT_EQ(oracle.count(points[0], 1.01), sphere.faces.size());
}

}  // namespace
}  // namespace sightline::tests
