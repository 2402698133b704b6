// Scenes of any size, and rays from any distance, equal the oracle; the scene's tree leaves most
// instances out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "scenegraph/query/build.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/expect_oracle.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"
#include "tests/support/kinds.h"
#include "tests/support/random.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using tests::Random;

constexpr int kInstances = 1000;

/// Spheres in a cube of this size around the origin, each a fiftieth of it.
std::vector<model::Update> spread_over(double size) {
  Random random(6);
  std::vector<model::Update> updates;
  const auto sphere = tests::mesh_of(tests::icosphere(1));
  for (int i = 1; i <= kInstances; ++i) {
    const double s = 0.01 * size;
    const auto x = [&] { return random.uniform(-size, size) / 2; };
    updates.emplace_back(
        tests::put_node(-i, 0, sphere, {{s, 0, 0, x(), 0, s, 0, x(), 0, 0, s, x()}}));
  }
  return updates;
}

/// From `distance` times the size.
std::vector<Ray> rays_at(double size, double distance, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) {
    const auto x = [&] { return random.uniform(-size, size) / 2; };
    const Vec3d at{x(), x(), x()};
    ray.direction = random.direction();
    ray.origin = at - ray.direction * (size * distance);
  }
  return rays;
}

class FarScenes : public ::testing::TestWithParam<double> {
 protected:
  void SetUp() override { ASSERT_TRUE(scene_.apply(spread_over(GetParam()))); }

  Scene scene_;
};
INSTANTIATE_TEST_SUITE_P(Sizes, FarScenes, ::testing::Values(1e-30, 1e-20, 1.0, 1e19, 1e25, 1e40));

TEST_P(FarScenes, EqualTheOracleForEveryKind) {
  const auto snapshot = scene_.snapshot();
  std::uint64_t hits = 0;
  for (const double distance : {0.0, 2.0, 1e3}) {
    const std::vector<Ray> rays = rays_at(GetParam(), distance, 150, 7);
    const tests::KindAnswers answers = tests::ask_all_kinds(*snapshot, rays, {});
    const tests::KindComparison compared =
        tests::compare_kinds(rays, answers, tests::BruteForce(snapshot), {});
    EXPECT_EQ(compared.mismatches, 0u) << compared.report();
    hits += compared.hits;
  }
  EXPECT_GT(hits, 100u);
}

TEST_P(FarScenes, LeaveMostInstancesOut) {
  const auto snapshot = scene_.snapshot();
  const std::vector<Ray> rays = rays_at(GetParam(), 2, 400, 8);
  std::vector<Hit> hits(rays.size());
  TraceOptions options;
  options.growth = Growth::kFull;
  std::uint64_t entered = 0, steps = 0;
  for (int again = 0; again < 3; ++again) {
    const auto traced = trace(*snapshot, rays, hits, options);
    ASSERT_TRUE(traced);
    entered = traced->instances_entered;
    steps = traced->traversal_steps;
  }
  // Where boxes are beyond floats, these know nothing.
  const int most = GetParam() < 1e38 ? 10 : kInstances + 1;
  EXPECT_LT(entered, static_cast<std::size_t>(most) * rays.size());
  EXPECT_LT(steps, 100 * rays.size());
}

/// They stay lists, whatever is asked for, and rays do not wait for them to grow.
TEST(FarMeshes, EqualTheOracleHoweverTreesGrow) {
  std::uint64_t hits = 0;
  for (const float size : {1e-15f, 1e20f}) {
    tests::TestMesh mesh = tests::icosphere(2);
    for (accel::geometry::Vec3f& v : mesh.vertices) v = v * size;
    for (const Growth growth :
         {Growth::kFirstTouch, Growth::kDemand, Growth::kNone, Growth::kFull}) {
      Scene scene;
      ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(mesh))}));
      const auto snapshot = scene.snapshot();
      const std::vector<Ray> rays = rays_at(static_cast<double>(size), 2, 200, 9);
      TraceOptions options;
      options.growth = growth;
      const tests::KindAnswers answers = tests::ask_all_kinds(*snapshot, rays, options);
      const tests::KindComparison compared =
          tests::compare_kinds(rays, answers, tests::BruteForce(snapshot), {});
      EXPECT_EQ(compared.mismatches, 0u) << compared.report();
      hits += compared.hits;
    }
  }
  EXPECT_GT(hits, 1000u);
}

/// Cubes that are stretched and turned, so that the rows of their transforms are almost parallel.
/// Their ends are where an error of the inverse shows.
TEST(Needles, EqualTheOracleAtTheirEnds) {
  Random random(10);
  std::uint64_t hits = 0;
  for (const double factor : {1e3, 1e5, 1e7, 1e9}) {
    Scene scene;
    std::vector<model::Update> updates;
    std::vector<Ray> rays;
    for (int i = 1; i <= 8; ++i) {
      const model::Affine scale{{factor, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
      const model::Affine world =
          compose(compose(random_frame(random, tests::Frames::kRigid, 4), scale),
                  random_frame(random, tests::Frames::kRigid, 0.1));
      updates.emplace_back(tests::put_node(-i, 0, tests::mesh_of(tests::cube()), world));
      double reach = 0;
      for (const accel::geometry::Vec3f& v : tests::cube().vertices)
        reach = std::max(reach, length(world.point(Vec3d(v))));
      for (int ray = 0; ray < 60; ++ray) {
        const accel::geometry::Vec3f corner = tests::cube().vertices[random.below(8)];
        const Vec3d at = world.point(Vec3d(corner) * (1 + random.uniform(-1, 1) * 1e-4));
        const Vec3d direction = random.direction();
        rays.push_back({at - direction * reach, direction});
      }
    }
    ASSERT_TRUE(scene.apply(updates));
    const auto snapshot = scene.snapshot();
    const tests::KindAnswers answers = tests::ask_all_kinds(*snapshot, rays, {});
    const tests::KindComparison compared =
        tests::compare_kinds(rays, answers, tests::BruteForce(snapshot), {});
    EXPECT_EQ(compared.mismatches, 0u) << factor << compared.report();
    hits += compared.hits;
  }
  EXPECT_GT(hits, 100u);
}

}  // namespace
}  // namespace sightline::scenegraph
