// The laws of lazy building for points, in counts, which are the same in every run on one thread.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <vector>

#include "scenegraph/trace.h"
#include "tests/support/hard_shapes.h"
#include "tests/support/point_scenes.h"
#include "tests/support/random.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using tests::FreshScene;
using tests::Random;
using tests::ScenePart;

constexpr std::uint32_t kTriangles = 80'000;

/// Hills over the unit square of x and z, up to a fifth high.
const std::vector<ScenePart>& scene_parts() {
  static const std::vector<ScenePart> parts{{tests::hills(kTriangles, 5)}};
  return parts;
}

struct Grown {
  double touches_per_triangle = 0, share_built = 0;
};

/// What first touches build in fresh trees, on one thread.
Grown grow(const std::vector<Ray>& questions, bool points, std::vector<Hit>* answers = nullptr) {
  const FreshScene scene(scene_parts());
  std::vector<Hit> hits(questions.size());
  tbb::task_arena one(1);
  const auto stats = one.execute([&] {
    return trace(*scene.snapshot(), questions, hits, {.surface = false, .points = points});
  });
  EXPECT_TRUE(stats.ok());
  const double triangles = static_cast<double>(scene.faces());
  const auto summary = revision::summarize_build(*scene.snapshot());
  if (answers != nullptr) *answers = hits;
  return {static_cast<double>(stats->touches + stats->touches_prepare) / triangles,
          static_cast<double>(summary.triangles_built) / triangles};
}

Ray point_at(const Vec3d& p) { return {.origin = p, .direction = {1, 0, 0}}; }

Vec3d in_ball(Random& random, double radius) {
  for (;;) {
    const Vec3d p{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (dot(p, p) <= 1) return p * radius;
  }
}

/// Rays onto the hills, not all of them from above, and points within a hundredth of the diagonal
/// around their ends.
TEST(LazyPoints, NearTheSurfaceBuildAsMuchAsRaysThatEndThere) {
  for (const std::size_t count : {1u, 30u, 1'000u}) {
    Random random(count);
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3d at{random.uniform(0.2, 0.8), 0, random.uniform(0.2, 0.8)},
          from = at + Vec3d{random.uniform(-1, 1), 2, random.uniform(-1, 1)};
      rays.push_back({.origin = from, .direction = at - from});
    }
    std::vector<Hit> hits;
    const Grown by_rays = grow(rays, false, &hits);
    std::vector<Ray> points;
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(hits[i].state, HitState::kHit);
      points.push_back(
          point_at(rays[i].origin + rays[i].direction * hits[i].t + in_ball(random, 0.014)));
    }
    const Grown by_points = grow(points, true);
    // The touches of a ball are about those of a ray that ends there.
    EXPECT_LE(by_points.touches_per_triangle, 1.1 * by_rays.touches_per_triangle) << count;
  }
}

TEST(LazyPoints, AroundOneSpotBuildLittle) {
  Random random(4);
  const tests::TestMesh& mesh = scene_parts()[0].mesh;
  const Vec3d spot(mesh.vertices[mesh.faces[kTriangles / 5][0]]);
  std::vector<Ray> points;
  while (points.size() < 10'000) points.push_back(point_at(spot + in_ball(random, 0.014)));
  const Grown built = grow(points, true);
  EXPECT_LE(built.share_built, 0.02);
  EXPECT_LE(built.touches_per_triangle, 3.5);
}

/// Points that are built for once are answered without building.
TEST(LazyPoints, BuildNothingTheSecondTime) {
  const FreshScene scene(scene_parts());
  Random random(6);
  std::vector<Ray> points;
  for (int i = 0; i < 200; ++i)
    points.push_back(point_at({random.uniform(), random.uniform(-1, 1), random.uniform()}));
  std::vector<Hit> hits(points.size());
  TraceOptions options;
  options.points = true;
  const auto first = trace(*scene.snapshot(), points, hits, options);
  const auto second = trace(*scene.snapshot(), points, hits, options);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_GT(first->cells_expanded, 0u);
  EXPECT_EQ(second->cells_expanded, 0u);
  EXPECT_EQ(second->touches + second->touches_prepare, 0u);
}

}  // namespace
}  // namespace sightline::scenegraph
