// Sample rays grow what a batch pays for: nothing for few rays, whole trees for many everywhere,
// and the same with any number of threads.
#include "scenegraph/query/sample_rays.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <vector>

#include "scenegraph/revision/snapshot.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/hard_shapes.h"
#include "tests/support/random.h"
#include "tests/support/rounds.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using tests::mesh_of;
using tests::put_node;

constexpr std::uint32_t kTriangles = 80'000;

/// Hills, and a ball of the same number of triangles beside them.
std::shared_ptr<const revision::Snapshot> two_meshes() {
  Scene scene;
  EXPECT_TRUE(scene.apply({put_node(-1, 0, mesh_of(tests::hills(kTriangles, 1))),
                           put_node(-2, 0, mesh_of(tests::icosphere(6)))}));
  return scene.snapshot();
}

/// Towards points of a square of this width around a corner of the hills, from above.
std::vector<Ray> rays_at(double width, std::size_t count) {
  tests::Random random(7);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d at{random.uniform() * width, random.uniform() * width, 0};
    rays.push_back({at + Vec3d{0.1, 0.05, 50}, {-0.1, -0.05, -50}});
  }
  return rays;
}

TraceStats cast(const revision::Snapshot& snapshot, const std::vector<Ray>& rays, Growth growth,
                std::vector<Hit>* hits = nullptr) {
  std::vector<Hit> found(rays.size());
  TraceOptions options;
  options.growth = growth;
  const auto stats = trace(snapshot, rays, found, options);
  EXPECT_TRUE(stats);
  if (hits != nullptr) *hits = found;
  return *stats;
}

void expect_same_hits(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].t, b[i].t) << i;
    ASSERT_EQ(a[i].node, b[i].node) << i;
    ASSERT_EQ(a[i].primitive, b[i].primitive) << i;
  }
}

std::uint64_t built_by(double width, std::size_t count, Growth growth) {
  const auto snapshot = two_meshes();
  const TraceStats stats = cast(*snapshot, rays_at(width, count), growth);
  return stats.touches + stats.touches_prepare;
}

TEST(SampleRays, BuildNothingForFewRays) {
  constexpr std::uint64_t kSceneTree = 16;  // touches of the tree over both instances
  EXPECT_LE(built_by(1, 4, Growth::kDemand), kSceneTree);
}

TEST(SampleRays, BuildWhatManyRaysNeedAndNoMore) {
  // A whole tree at once costs less than the same tree piece by piece.
  EXPECT_LT(built_by(0.1, 4096, Growth::kDemand), built_by(1, 65536, Growth::kDemand) / 2);
}

TEST(SampleRays, LeaveTheAnswersAsTheyAre) {
  for (const double width : {0.02, 0.3, 1.0}) {
    for (const std::size_t count :
         {std::size_t{1}, std::size_t{16}, std::size_t{300}, tests::rounds(5000)}) {
      const std::vector<Ray> rays = rays_at(width, count);
      std::vector<Hit> expected, hits;
      cast(*two_meshes(), rays, Growth::kNone, &expected);
      const auto snapshot = two_meshes();
      for (int again = 0; again < 3; ++again) {
        cast(*snapshot, rays, Growth::kDemand, &hits);
        expect_same_hits(hits, expected);
      }
    }
  }
}

TEST(SampleRays, MakeTheSameTreesOfTheSameBatches) {
  tbb::task_arena arena(1);
  arena.execute([] {
    const auto one = two_meshes(), other = two_meshes();
    for (const double width : {0.1, 0.5}) {
      const std::vector<Ray> rays = rays_at(width, 3000);
      const TraceStats a = cast(*one, rays, Growth::kDemand),
                       b = cast(*other, rays, Growth::kDemand);
      EXPECT_EQ(a.cells_expanded, b.cells_expanded);
      EXPECT_EQ(a.touches, b.touches);
      EXPECT_EQ(a.traversal_steps, b.traversal_steps);
      EXPECT_EQ(a.triangle_tests, b.triangle_tests);
    }
    EXPECT_EQ(revision::summarize_build(*one).bytes_trees,
              revision::summarize_build(*other).bytes_trees);
  });
}

TEST(SampleRays, ARepeatedBatchReachesAFixedPoint) {
  constexpr int kRepeats = 20;
  tbb::task_arena arena(1);
  arena.execute([] {
    for (const std::size_t count : {1u, 20u, 700u, 5000u}) {
      const auto snapshot = two_meshes();
      const std::vector<Ray> rays = rays_at(0.3, count);
      for (int i = 0; i < kRepeats; ++i) cast(*snapshot, rays, Growth::kDemand);
      TraceStats before = cast(*snapshot, rays, Growth::kDemand);
      for (int i = 0; i < 3; ++i) {
        const TraceStats again = cast(*snapshot, rays, Growth::kDemand);
        EXPECT_EQ(again.cells_expanded, 0u) << count;
        EXPECT_EQ(again.triangle_tests, before.triangle_tests) << count;
      }
    }
  });
}

}  // namespace
}  // namespace sightline::scenegraph::query
