// With the exact test the bench's walk gives the product's answers; with the plain float test it
// has that test's known faults.
#include "tests/bench/verbs/kernel_walk.h"
#include "accel/mesh/mesh_tree.h"

#include <gtest/gtest.h>

#include "scenegraph/trace.h"
#include "tests/bench/scenes/generators.h"
#include "tests/bench/scenes/ray_kinds.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/plain_float.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using scenegraph::QueryKind;

std::vector<Ray> some_rays(const SceneSource& scene, RayKind kind) {
  return *make_rays(scene, kind, 700, 1);
}

std::vector<std::uint32_t> product_counts(const scenegraph::revision::Snapshot& snapshot,
                                          const std::vector<Ray>& rays) {
  std::vector<scenegraph::RayTally> tallies(rays.size());
  EXPECT_TRUE(scenegraph::count_hits(snapshot, rays, tallies, {.kind = QueryKind::kCount}).ok());
  std::vector<std::uint32_t> counts;
  for (const auto& tally : tallies) counts.push_back(tally.count);
  return counts;
}

TEST(KernelWalk, TheExactTestGivesTheProductsAnswers) {
  for (const SceneSource& scene : {make_city(600, 1), make_icosphere(3, 1e5)}) {
    for (const RayKind kind : {RayKind::kRandom, RayKind::kAimed}) {
      const std::vector<Ray> rays = some_rays(scene, kind);
      const auto snapshot = *assemble(scene, {});
      ASSERT_TRUE(scenegraph::build_all(*snapshot).ok());
      std::vector<Hit> product(rays.size()), bench(rays.size());
      ASSERT_TRUE(scenegraph::trace(*snapshot, rays, product, {}).ok());
      trace_closest(snapshot->trees().static_tree(), TriangleTest::kExact, rays, bench);
      EXPECT_EQ(hit_hash(bench, QueryKind::kClosest), hit_hash(product, QueryKind::kClosest));
      for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(bench[i].t, product[i].t);

      std::vector<std::uint32_t> counts(rays.size());
      count_crossings(snapshot->trees().static_tree(), TriangleTest::kExact, rays, counts);
      EXPECT_EQ(counts, product_counts(*snapshot, rays));
    }
  }
}

TEST(KernelWalk, ScansCellsThatAreNotBuilt) {
  const SceneSource scene = make_city(300, 1);
  const std::vector<Ray> rays = some_rays(scene, RayKind::kRandom);
  const auto untouched = *assemble(scene, {}), full = *assemble(scene, {});
  std::vector<std::uint32_t> counts(rays.size());
  count_crossings(untouched->trees().static_tree(), TriangleTest::kExact, rays, counts);
  EXPECT_EQ(counts, product_counts(*full, rays));
  EXPECT_TRUE(untouched->meshes().front()->tree().untouched());
}

TEST(KernelWalk, PlainFloatAgreesAwayFromEdges) {
  const SceneSource scene = make_icosphere(2, 0);
  const std::vector<Ray> rays = some_rays(scene, RayKind::kRandom);
  const auto snapshot = *assemble(scene, {});
  ASSERT_TRUE(scenegraph::build_all(*snapshot).ok());
  std::vector<Hit> exact(rays.size()), plain(rays.size());
  trace_closest(snapshot->trees().static_tree(), TriangleTest::kExact, rays, exact);
  trace_closest(snapshot->trees().static_tree(), TriangleTest::kPlainFloat, rays, plain);
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(exact[i].state, plain[i].state) << i;
    if (exact[i].state != accel::geometry::HitState::kHit) continue;
    ++hits;
    EXPECT_NEAR(exact[i].t, plain[i].t, 1e-5);
  }
  EXPECT_GT(hits, 100u);
}

TEST(PlainFloat, HitsASharedEdgeFromBothSides) {
  // Parity counting fails with this fault; exact hits give the edge to one triangle.
  const accel::geometry::Vec3f a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0}, d{1, 1, 0};
  const auto ray = accel::geometry::make_local_ray({0.5, 0.5, 1}, {0, 0, -2});
  const PlainFloat plain(*ray);
  ASSERT_TRUE(plain(a, b, c) && plain(b, d, c));
  EXPECT_EQ(*plain(a, b, c) * ray->unit, 0.5);
  EXPECT_EQ(*plain(c, b, a) * ray->unit, 0.5);
  EXPECT_FALSE(plain(a, b, {2, 0, 0}));
  const auto beside = accel::geometry::make_local_ray({0.6, 0.6, 1}, {0, 0, -2});
  EXPECT_FALSE(PlainFloat(*beside)(a, b, c));
  const auto behind = accel::geometry::make_local_ray({0.25, 0.25, -1}, {0, 0, -1});
  EXPECT_LT(*PlainFloat(*behind)(a, b, c), 0);
}

}  // namespace
}  // namespace sightline::bench
