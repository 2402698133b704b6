// The oracle against answers known in closed form.
#include "tests/support/brute_force.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenegraph/scene.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using scenegraph::model::Affine;

Ray ray(const Vec3d& origin, const Vec3d& direction) {
  Ray r;
  r.origin = origin;
  r.direction = direction;
  return r;
}

BruteForce over(const TestMesh& mesh) { return BruteForce({{.mesh = mesh.view()}}); }

TEST(BruteForce, SingleTriangleGivesTAndBarycentrics) {
  const TestMesh mesh = single_triangle();
  const BruteForce oracle = over(mesh);
  const Reference hit = oracle.trace(ray({0.25, 0.5, 3}, {0, 0, -2}));
  ASSERT_NE(hit.closest(), nullptr);
  EXPECT_DOUBLE_EQ(hit.closest()->t, 1.5);
  EXPECT_DOUBLE_EQ(hit.closest()->u, 0.25);
  EXPECT_DOUBLE_EQ(hit.closest()->v, 0.5);
  EXPECT_EQ(hit.closest()->node, 1u);
  EXPECT_EQ(hit.closest()->normal, (Vec3d{0, 0, 1}));
  EXPECT_FALSE(hit.closest()->borderline);

  EXPECT_EQ(oracle.trace(ray({0.75, 0.5, 3}, {0, 0, -2})).closest(), nullptr);
  EXPECT_EQ(oracle.trace(ray({0.25, 0.5, 3}, {0, 0, 2})).closest(), nullptr);
}

TEST(BruteForce, IntervalIsClosedAndItsEndsAreBorderline) {
  const TestMesh mesh = single_triangle();
  const BruteForce oracle = over(mesh);
  Ray r = ray({0.25, 0.25, 1}, {0, 0, -1});
  r.tmax = 1;
  Reference at_end = oracle.trace(r);
  ASSERT_NE(at_end.closest(), nullptr);
  EXPECT_TRUE(at_end.closest()->borderline);
  r.tmax = 0.999;
  EXPECT_TRUE(oracle.trace(r).candidates.empty());
  r.tmax = accel::geometry::kInfinity;
  r.tmin = 1.001;
  EXPECT_TRUE(oracle.trace(r).candidates.empty());
}

TEST(BruteForce, EdgesBelongToTheTriangleAndAreMarked) {
  const TestMesh mesh = single_triangle();
  const BruteForce oracle = over(mesh);
  const Reference on_edge = oracle.trace(ray({0.5, 0, 1}, {0, 0, -1}));
  ASSERT_NE(on_edge.closest(), nullptr);
  EXPECT_TRUE(on_edge.closest()->borderline);
  const Reference just_outside = oracle.trace(ray({0.5, -1e-14, 1}, {0, 0, -1}));
  EXPECT_EQ(just_outside.closest(), nullptr);
  ASSERT_EQ(just_outside.candidates.size(), 1u);
  EXPECT_TRUE(just_outside.candidates[0].borderline);
  EXPECT_TRUE(oracle.trace(ray({0.5, -1e-9, 1}, {0, 0, -1})).candidates.empty());
}

TEST(BruteForce, RayInThePlaneIsNoHit) {
  const TestMesh mesh = single_triangle();
  EXPECT_EQ(over(mesh).trace(ray({-1, 0.25, 0}, {1, 0, 0})).closest(), nullptr);
}

TEST(BruteForce, CubeGivesItsSides) {
  const TestMesh mesh = cube();
  const BruteForce oracle = over(mesh);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vec3d origin{0.25, 0.375, 0.125}, direction{};
      origin[axis] = 3 * sign;
      direction[axis] = -sign;
      const Reference hit = oracle.trace(ray(origin, direction));
      ASSERT_NE(hit.closest(), nullptr);
      EXPECT_DOUBLE_EQ(hit.closest()->t, 2);
      EXPECT_EQ(hit.closest()->primitive / 2, 2 * axis + (sign > 0 ? 1 : 0));
      EXPECT_DOUBLE_EQ(hit.closest()->normal[axis], sign);
    }
  }
}

TEST(BruteForce, StaircaseAndWallsGiveTheNearestHit) {
  const TestMesh stairs = staircase(10);
  const BruteForce on_stairs = over(stairs);
  const TestMesh walls = flat_walls(10);
  const BruteForce on_walls = over(walls);
  for (std::uint32_t i = 0; i + 1 < 10; ++i) {
    const Reference tread = on_stairs.trace(ray({i + 0.5, 0.3, 20}, {0, 0, -1}));
    ASSERT_NE(tread.closest(), nullptr);
    EXPECT_DOUBLE_EQ(tread.closest()->t, 20.0 - i);
    EXPECT_EQ(tread.closest()->primitive / 2, 2 * i);
    const Reference wall = on_walls.trace(ray({i + 0.5, 0.3, 0.6}, {1, 0, 0}));
    ASSERT_NE(wall.closest(), nullptr);
    EXPECT_DOUBLE_EQ(wall.closest()->t, 0.5);
    EXPECT_EQ(wall.closest()->primitive / 2, i + 1);
  }
}

TEST(BruteForce, EqualTGoesToTheLeastNodeThenPrimitiveAndTiesAreKept) {
  const TestMesh mesh = duplicates(5);
  const BruteForce oracle({{.mesh = mesh.view(), .node = 7}, {.mesh = mesh.view(), .node = 3}});
  const Reference hit = oracle.trace(ray({0.25, 0.25, 1}, {0, 0, -1}));
  ASSERT_EQ(hit.candidates.size(), 10u);
  EXPECT_EQ(hit.closest()->node, 3u);
  EXPECT_EQ(hit.closest()->primitive, 0u);
  EXPECT_EQ(hit.candidates[9].node, 7u);
  EXPECT_EQ(hit.candidates[9].primitive, 4u);
}

TEST(BruteForce, TransformsMeshes) {
  const TestMesh mesh = single_triangle();
  // Scaled by 2 in x, mirrored in z, far away.
  const Affine placed{{2, 0, 0, 1e6, 0, 1, 0, 0, 0, 0, -1, 5}};
  const BruteForce oracle({{.mesh = mesh.view(), .world_from_local = placed, .node = 9}});
  const Reference hit = oracle.trace(ray({1e6 + 0.5, 0.5, 10}, {0, 0, -1}));
  ASSERT_NE(hit.closest(), nullptr);
  EXPECT_DOUBLE_EQ(hit.closest()->t, 5);
  EXPECT_DOUBLE_EQ(hit.closest()->u, 0.25);
  EXPECT_DOUBLE_EQ(hit.closest()->normal.z, -1) << "stays on the side of the mesh's front";
  EXPECT_EQ(hit.closest()->side, 1) << "which is mirrored away from the ray";
}

TEST(BruteForce, MasksHideInstances) {
  const TestMesh mesh = single_triangle();
  const BruteForce oracle({{.mesh = mesh.view(), .mask = 0b01}});
  Ray r = ray({0.25, 0.25, 1}, {0, 0, -1});
  r.mask = 0b10;
  EXPECT_EQ(oracle.trace(r).closest(), nullptr);
  r.mask = 0b11;
  EXPECT_NE(oracle.trace(r).closest(), nullptr);
}

TEST(BruteForce, BadRaysAreInvalid) {
  const TestMesh mesh = single_triangle();
  const BruteForce oracle = over(mesh);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(oracle.trace(ray({nan, 0, 0}, {0, 0, 1})).invalid);
  EXPECT_TRUE(oracle.trace(ray({0, 0, 0}, {0, 0, 0})).invalid);
  EXPECT_TRUE(oracle.trace(ray({0, 0, 0}, {0, accel::geometry::kInfinity, 0})).invalid);
}

TEST(BruteForce, BadTrianglesAreNeverHit) {
  TestMesh mesh = single_triangle();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  mesh.vertices.push_back({nan, 0, 0});
  mesh.faces = {
      {0, 1, 3},
      {accel::geometry::kNoVertex, accel::geometry::kNoVertex, accel::geometry::kNoVertex},
      {0, 1, 1},
      {0, 1, 2}};
  const Reference hit = over(mesh).trace(ray({0.25, 0.25, 1}, {0, 0, -1}));
  ASSERT_EQ(hit.candidates.size(), 1u);
  EXPECT_EQ(hit.candidates[0].primitive, 3u);
}

TEST(BruteForce, TinyAndHugeDirectionsChangeOnlyT) {
  const TestMesh mesh = single_triangle();
  const BruteForce oracle = over(mesh);
  for (const double scale : {1e-150, 1e-3, 1e3, 1e150}) {
    const Reference hit = oracle.trace(ray({0.25, 0.25, 1}, {0, 0, -scale}));
    ASSERT_NE(hit.closest(), nullptr) << scale;
    EXPECT_DOUBLE_EQ(hit.closest()->t, 1 / scale);
  }
}

// Boxes must reject no hit: an oracle over a single triangle has no box.
TEST(BruteForce, BoxesRejectNoHitOfASoup) {
  const TestMesh soup = random_soup(500, 0.2, 5);
  const std::vector<Ray> rays = rays_at(soup, 200, 6);
  const BruteForce oracle = over(soup);
  const std::vector<Reference> together = oracle.trace(rays);
  std::vector<double> nearest(rays.size(), accel::geometry::kInfinity);
  std::vector<std::uint32_t> primitive(rays.size());
  for (std::uint32_t f = 0; f < soup.faces.size(); ++f) {
    const TestMesh one{soup.vertices, {soup.faces[f]}};
    const BruteForce alone = over(one);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Reference hit = alone.trace(rays[i]);
      if (hit.closest() == nullptr || hit.closest()->t >= nearest[i]) continue;
      nearest[i] = hit.closest()->t;
      primitive[i] = f;
    }
  }
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Candidate* closest = together[i].closest();
    ASSERT_EQ(closest != nullptr, nearest[i] < accel::geometry::kInfinity) << i;
    if (closest == nullptr) continue;
    ++hits;
    EXPECT_EQ(closest->t, nearest[i]);
    EXPECT_EQ(closest->primitive, primitive[i]);
  }
  EXPECT_GT(hits, 100u);
}

TEST(BruteForce, SphereIsHitNearItsRadius) {
  const TestMesh sphere = icosphere(4);
  const BruteForce oracle = over(sphere);
  const std::vector<Ray> rays = rays_at(sphere, 200, 1);
  for (const Ray& r : rays) {
    const double along = -dot(r.origin, r.direction) / dot(r.direction, r.direction);
    const double off = length(r.origin + r.direction * along);
    const Reference reference = oracle.trace(r);
    const Candidate* hit = reference.closest();
    if (off > 1.0001) {
      EXPECT_EQ(hit, nullptr);
    }
    if (off > 0.99) continue;
    ASSERT_NE(hit, nullptr);
    EXPECT_NEAR(length(r.origin + r.direction * hit->t), 1, 0.01);
  }
}

TEST(BruteForce, WalksTheSnapshotsHierarchy) {
  const TestMesh mesh = single_triangle();
  auto made = scenegraph::model::Mesh::make(mesh.vertices, mesh.faces);
  ASSERT_TRUE(made.ok());
  const auto put = [&](scenegraph::model::NodeRef node, scenegraph::model::NodeRef parent, double z,
                       bool leaf, double height = 1) {
    scenegraph::model::PutNode p;
    p.node = node;
    p.parent = parent;
    p.parent_from_local = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, height, z}};
    if (leaf) p.mesh = *made;
    return scenegraph::model::Update(p);
  };
  scenegraph::Scene scene;
  const auto applied =
      scene.apply({put(-1, 0, 10, false), put(-2, -1, 1, true), put(-3, -1, 2, true),
                   put(-4, -1, 3, true, 0), put(-5, -4, 4, true), put(-6, -1, 5, true, 1e-13)});
  ASSERT_TRUE(applied.ok());
  const BruteForce oracle(scene.snapshot());
  const Reference hit = oracle.trace(ray({0.25, 0.25, 20}, {0, 0, -1}));
  ASSERT_NE(hit.closest(), nullptr);
  EXPECT_DOUBLE_EQ(hit.closest()->t, 8);
  EXPECT_EQ(hit.closest()->node, applied->nodes[2]);
}

}  // namespace
}  // namespace sightline::tests
