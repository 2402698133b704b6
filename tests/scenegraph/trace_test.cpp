// Ray batches at the scene level: instances, transforms, masks, growth, threads.
#include "scenegraph/trace.h"

#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "scenegraph/query/ray_blocks.h"
#include "scenegraph/scene.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::geometry::Vec3d;

/// Two meshes, many instances: rotated, sheared, mirrored, overlapping, some under a moved parent.
std::shared_ptr<const revision::Snapshot> random_scene(int instances, double reach = 4) {
  tests::Random random(21);
  const auto sphere = tests::mesh_of(tests::icosphere(5)),
             soup = tests::mesh_of(tests::random_soup(500, 0.2, 5));
  Scene scene;
  std::vector<model::Update> updates{
      tests::put_node(-1, 0, nullptr, tests::random_frame(random, tests::Frames::kSheared, 1))};
  for (int i = 0; i < instances; ++i) {
    updates.push_back(tests::put_node(-2 - i, i % 2 == 0 ? -1 : 0, i % 3 == 0 ? soup : sphere,
                                      tests::random_frame(random, tests::Frames::kSheared, reach)));
  }
  EXPECT_TRUE(scene.apply(updates));
  return scene.snapshot();
}

std::vector<Hit> cast(const revision::Snapshot& snapshot, const std::vector<Ray>& rays,
                      TraceOptions options = {}) {
  std::vector<Hit> hits(rays.size());
  const auto stats = trace(snapshot, rays, hits, options);
  EXPECT_TRUE(stats);
  EXPECT_EQ(stats->rays, rays.size());
  return hits;
}

bool same(const Hit& a, const Hit& b) {
  return std::memcmp(&a.t, &b.t, sizeof a.t) == 0 && a.node == b.node &&
         a.primitive == b.primitive && a.u == b.u && a.v == b.v && a.normal == b.normal &&
         a.state == b.state;
}

void expect_same(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(same(a[i], b[i])) << "ray " << i;
}

TEST(Trace, EqualsTheOracleOverInstances) {
  const auto snapshot = random_scene(40);
  const std::vector<Ray> rays = tests::rays_through(*snapshot, 3000, 1);
  const tests::BruteForce oracle(snapshot);
  const auto comparison =
      tests::compare(rays, cast(*snapshot, rays), oracle, {.any = false, .surface = true});
  EXPECT_TRUE(comparison.clean()) << comparison.report();
  EXPECT_GT(comparison.hits, 500u);
}

TEST(Trace, LazyFullAndScannedAgreeForAnyThreadsAndBatches) {
  const std::vector<Ray> rays = tests::rays_through(*random_scene(60), 4000, 2);
  TraceOptions full;
  full.growth = Growth::kFull;
  const std::vector<Hit> expected = cast(*random_scene(60), rays, full);
  for (const int threads : {1, 2, 8}) {
    const auto snapshot = random_scene(60);
    tbb::task_arena arena(threads);
    arena.execute([&] { expect_same(cast(*snapshot, rays), expected); });
  }
  TraceOptions none;
  none.growth = Growth::kNone;
  const std::vector<Ray> few(rays.begin(), rays.begin() + 200);
  expect_same(cast(*random_scene(60), few, none), {expected.begin(), expected.begin() + 200});
  // One by one, in reverse, against a tree that grows differently.
  const auto snapshot = random_scene(60);
  for (std::size_t i = rays.size(); i-- > rays.size() - 500;) {
    ASSERT_TRUE(same(cast(*snapshot, {rays[i]})[0], expected[i]));
  }
}

TEST(Trace, AnyAgreesWithClosest) {
  const auto snapshot = random_scene(40);
  const std::vector<Ray> rays = tests::rays_through(*snapshot, 2000, 3);
  TraceOptions any;
  any.kind = QueryKind::kAny;
  const std::vector<Hit> occluded = cast(*random_scene(40), rays, any),
                         closest = cast(*snapshot, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(occluded[i].state == HitState::kHit, std::isfinite(closest[i].t));
  }
}

TEST(Trace, RepeatedRaysExpandNothing) {
  const auto snapshot = random_scene(40);
  const std::vector<Ray> rays = tests::rays_through(*snapshot, 1000, 4);
  std::vector<Hit> hits(rays.size());
  // On one thread: with several, a ray that comes second to a busy cell would scan its list and
  // leave it deferred.
  tbb::task_arena arena(1);
  arena.execute([&] {
    EXPECT_GT(trace(*snapshot, rays, hits, {})->cells_expanded, 0u);
    const auto again = trace(*snapshot, rays, hits, {});
    EXPECT_EQ(again->cells_expanded, 0u);
    EXPECT_EQ(again->touches, 0u);
  });
}

TEST(Trace, OnlyEnteredInstancesGrow) {
  const auto sphere = tests::mesh_of(tests::icosphere(5)),
             other = tests::mesh_of(tests::icosphere(4));
  Scene scene;
  ASSERT_TRUE(scene.apply(
      {tests::put_node(-1, 0, sphere),
       tests::put_node(-2, 0, other, model::Affine{{1, 0, 0, 100, 0, 1, 0, 0, 0, 0, 1, 0}})}));
  const auto snapshot = scene.snapshot();
  EXPECT_EQ(cast(*snapshot, {Ray{{0, 0, 5}, {0, 0, -1}}})[0].node, 1u);
  const revision::BuildSummary s = summarize_build(*snapshot);
  EXPECT_EQ(s.instances_total, 2u);
  EXPECT_EQ(s.instances_entered, 1u);
  EXPECT_EQ(s.trees_built, 1u);
  EXPECT_GT(s.triangles_built, 0u);
  EXPECT_LT(s.triangles_built, sphere->triangles());
  EXPECT_TRUE(other->tree().untouched());
  // Grown cells are kept when the scene changes.
  ASSERT_TRUE(scene.apply(
      {model::SetTransforms{{2}, {model::Affine{{1, 0, 0, 50, 0, 1, 0, 0, 0, 0, 1, 0}}}}}));
  EXPECT_EQ(summarize_build(*scene.snapshot()).triangles_built, s.triangles_built);
}

TEST(Trace, BuiltOnlySkipsDeferredCells) {
  const auto snapshot = random_scene(10);
  const std::vector<Ray> rays = tests::rays_through(*snapshot, 200, 6);
  TraceOptions sketch;
  sketch.growth = Growth::kBuiltOnly;
  for (const Hit& hit : cast(*snapshot, rays, sketch)) {
    EXPECT_EQ(hit.state, HitState::kMiss);
    EXPECT_EQ(hit.work & ~accel::geometry::kWorkDeferred, 0u);
  }
  EXPECT_EQ(summarize_build(*snapshot).instances_entered, 0u);
  ASSERT_TRUE(build_all(*snapshot));
  expect_same(cast(*snapshot, rays, sketch), cast(*snapshot, rays));
}

TEST(Trace, MarksBadRaysAndAnswersTheOthers) {
  const auto snapshot = random_scene(5);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = accel::geometry::kInfinity;
  std::vector<Ray> rays = tests::rays_through(*snapshot, 7, 7);
  const std::vector<Hit> good = cast(*snapshot, rays);
  rays[0].direction = {0, 0, 0};
  rays[1].origin.x = nan;
  rays[2].direction.y = inf;
  rays[3].tmin = nan;
  rays[4].tmax = nan;
  std::vector<Hit> hits(rays.size());
  const auto stats = trace(*snapshot, rays, hits, {});
  ASSERT_TRUE(stats);
  EXPECT_EQ(stats->invalid, 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(hits[static_cast<std::size_t>(i)].state, HitState::kInvalid);
    EXPECT_TRUE(std::isnan(hits[static_cast<std::size_t>(i)].t));
    EXPECT_EQ(hits[static_cast<std::size_t>(i)].node, 0u);
  }
  EXPECT_TRUE(same(hits[5], good[5]));
  EXPECT_TRUE(same(hits[6], good[6]));
}

TEST(Trace, LimitsAreClosedAndMasksHide) {
  Scene scene;
  model::PutNode wall = tests::put_node(-1, 0, tests::mesh_of(tests::cube()));
  wall.mask = 2;
  ASSERT_TRUE(scene.apply({wall}));
  const auto snapshot = scene.snapshot();
  const Ray ray{{0.25, 0.125, 5}, {0, 0, -2}};
  const auto t_of = [&](Ray r) { return cast(*snapshot, {r})[0].t; };
  EXPECT_EQ(t_of(ray), 2);
  Ray limited = ray;
  limited.tmax = 2;
  EXPECT_EQ(t_of(limited), 2);
  limited.tmax = std::nextafter(2.0, 0.0);
  EXPECT_EQ(t_of(limited), accel::geometry::kInfinity);
  limited = ray;
  limited.tmin = 2;
  EXPECT_EQ(t_of(limited), 2);
  limited.tmin = std::nextafter(2.0, 3.0);
  EXPECT_EQ(t_of(limited), 3);
  limited.tmin = 4;
  limited.tmax = 3;
  EXPECT_EQ(t_of(limited), accel::geometry::kInfinity);
  limited = ray;
  limited.mask = 1;
  EXPECT_EQ(t_of(limited), accel::geometry::kInfinity);
  limited.mask = 3;
  EXPECT_EQ(t_of(limited), 2);
}

TEST(Trace, TiesGoToTheSmallestNodeThenFace) {
  const auto mesh = tests::mesh_of(tests::duplicates(5));
  Scene scene;
  ASSERT_TRUE(scene.apply(
      {tests::put_node(-1, 0, mesh), tests::put_node(-2, 0, mesh), tests::put_node(-3, 0, mesh)}));
  ASSERT_TRUE(scene.apply({model::DeleteNode{1}}));
  const Hit hit = cast(*scene.snapshot(), {Ray{{0.2, 0.2, 1}, {0, 0, -1}}})[0];
  EXPECT_EQ(hit.node, 2u);
  EXPECT_EQ(hit.primitive, 0u);
}

TEST(Trace, MillimetresTenThousandKilometresOut) {
  const auto sphere = tests::mesh_of(tests::icosphere(3));
  const model::Affine far{{1e-3, 0, 0, 1e7, 0, 1e-3, 0, -1e7, 0, 0, 1e-3, 1e7}};
  Scene scene, home;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, sphere, far)}));
  ASSERT_TRUE(home.apply({tests::put_node(
      -1, 0, sphere, model::Affine{{1e-3, 0, 0, 0, 0, 1e-3, 0, 0, 0, 0, 1e-3, 0}})}));
  // On a lattice of 2^-20 the far origin is exact.
  const auto lattice = [](double x) { return std::round(x * 0x1p+20) * 0x1p-20; };
  tests::Random random(5);
  for (int i = 0; i < 500; ++i) {
    Ray ray;
    ray.origin = {lattice(random.uniform(-1, 1)), lattice(random.uniform(-1, 1)), 2};
    ray.direction = Vec3d{random.uniform(-5e-4, 5e-4), random.uniform(-5e-4, 5e-4), 0} - ray.origin;
    const Hit here = cast(*home.snapshot(), {ray})[0];
    ray.origin = ray.origin + Vec3d{1e7, -1e7, 1e7};
    const Hit there = cast(*scene.snapshot(), {ray})[0];
    ASSERT_EQ(here.state, HitState::kHit);
    ASSERT_EQ(there.state, HitState::kHit);
    ASSERT_NEAR(there.t, here.t, 1e-7);
  }
}

TEST(Trace, StopsBetweenPostponedPackets) {
  Scene scene;
  const auto snapshot = scene.snapshot();
  accel::kdtree::EpochPin pin;
  const query::Caster caster(pin, snapshot->trees(), QueryKind::kClosest, {});
  std::vector<query::RayPacket> postponed(5, {0, accel::wide::kLanes});
  std::atomic<bool> cancelled{false};
  query::answer_postponed(postponed, caster, &cancelled, [&](const query::RayPacket&, bool) {
    cancelled = postponed.size() == 3;
    return 0u;
  });
  EXPECT_EQ(postponed.size(), 2u);
}

TEST(Trace, StopsWhenCancelled) {
  const auto snapshot = random_scene(5);
  const std::vector<Ray> rays = tests::rays_through(*snapshot, 2000, 8);
  std::vector<Hit> hits(rays.size());
  const std::atomic<bool> cancelled{true};
  TraceOptions options;
  options.cancelled = &cancelled;
  const auto stats = trace(*snapshot, rays, hits, options);
  ASSERT_FALSE(stats);
  EXPECT_EQ(stats.error().code, Code::kCancelled);
  options.growth = Growth::kFull;
  EXPECT_FALSE(trace(*snapshot, rays, hits, options));
  EXPECT_FALSE(trace(*snapshot, rays, std::span(hits).first(3), {}));
}

TEST(Trace, EmptyScenesAndBatches) {
  const Scene scene;
  EXPECT_EQ(cast(*scene.snapshot(), {Ray{{0, 0, 0}, {1, 0, 0}}})[0].state, HitState::kMiss);
  EXPECT_TRUE(cast(*random_scene(1), {}).empty());
  EXPECT_TRUE(build_all(*scene.snapshot()));
}

TEST(Trace, EightThreadsMeetInAColdScene) {
  const auto snapshot = random_scene(80, 2);
  const std::vector<Ray> rays = tests::rays_through(*snapshot, 3000, 9);
  const std::vector<Hit> expected = cast(*random_scene(80, 2), rays);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      const std::vector<Hit> hits = cast(*snapshot, rays);
      for (std::size_t k = 0; k < hits.size(); ++k) wrong += same(hits[k], expected[k]) ? 0 : 1;
    });
  }
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, 0);
}

TEST(Trace, AnswersStayWholeWhileTheSceneChanges) {
  const auto sphere = tests::mesh_of(tests::icosphere(3));
  Scene scene;
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, sphere)}));
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    for (int i = 1; !stop; ++i) {
      const double z = i % 2 == 0 ? 0.0 : 10.0;
      EXPECT_TRUE(scene.apply(
          {model::SetTransforms{{1}, {model::Affine{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, z}}}}}));
    }
  });
  const std::vector<Ray> rays(2000, Ray{{0.1, 0.1, 50}, {0, 0, -1}});
  for (int round = 0; round < 20; ++round) {
    const std::vector<Hit> hits = cast(*scene.snapshot(), rays);
    for (const Hit& hit : hits) ASSERT_EQ(hit.t, hits[0].t);
  }
  stop = true;
  writer.join();
}

/// Surfaces come from blocks where these are built, and from the mesh elsewhere.
TEST(Trace, NormalsAreEqualInEachBitHoweverMuchIsBuilt) {
  tests::TestMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 1, 0}, {-1, 1, -0.0F}};
  mesh.faces = {{0, 1, 2}};
  Scene scene;
  const model::Affine reflection{{0.8, -0.6, 0, 0, -0.6, -0.8, 0, 0, 0, 0, 1, 0}};
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, tests::mesh_of(mesh), reflection)}));
  const Ray rays[] = {{{-0.3, -0.4, 1}, {0, 0, -1}}, {{-0.34, -0.62, 2}, {0, 0, -1}}};
  Hit searched[2], built[2];
  TraceOptions options;
  options.growth = Growth::kNone;
  ASSERT_TRUE(trace(*scene.snapshot(), rays, searched, options));
  options.growth = Growth::kFirstTouch;
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(trace(*scene.snapshot(), rays, built, options));
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(searched[i].state, accel::geometry::HitState::kHit);
    EXPECT_EQ(std::memcmp(&searched[i].normal, &built[i].normal, sizeof(searched[i].normal)), 0);
  }
}

}  // namespace
}  // namespace sightline::scenegraph
