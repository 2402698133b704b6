// Rays through lazily opened hierarchies: the same hits as with everything opened, with few groups
// opened.
#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <cmath>
#include <cstring>
#include <thread>

#include "scenegraph/instances/sibling_clusters.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/all_instances.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"
#include "tests/support/rounds.h"

namespace sightline::scenegraph::instances {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using tests::Frames;

std::vector<Hit> cast(const revision::Snapshot& snapshot, const std::vector<Ray>& rays,
                      const TraceOptions& options = {}) {
  std::vector<Hit> hits(rays.size());
  EXPECT_TRUE(trace(snapshot, rays, hits, options));
  return hits;
}

void expect_same(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(std::memcmp(&a[i].t, &b[i].t, sizeof a[i].t), 0) << i;
    ASSERT_EQ(a[i].node, b[i].node) << i;
    ASSERT_EQ(a[i].primitive, b[i].primitive) << i;
    ASSERT_EQ(a[i].normal, b[i].normal) << i;
  }
}

class HierarchyInFrames : public testing::TestWithParam<Frames> {};

TEST_P(HierarchyInFrames, LazyOpeningEqualsFullOpeningAndTheOracle) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto updates = tests::random_hierarchy(400, GetParam(), seed);
    const auto opened = tests::snapshot_of(updates);
    (void)tests::all_instances(opened->trees().static_tree());
    const std::vector<Ray> rays = tests::rays_through(*opened, tests::rounds(1000), seed);
    const std::vector<Hit> expected = cast(*opened, rays);
    const tests::BruteForce oracle(opened);
    const auto compared = tests::compare(rays, expected, oracle);
    EXPECT_TRUE(compared.clean()) << compared.report();
    EXPECT_GT(compared.hits, tests::rounds(1000) / 10);
    for (const int threads : {1, 2, 8}) {
      const auto cold = tests::snapshot_of(updates);
      tbb::task_arena arena(threads);
      arena.execute([&] { expect_same(cast(*cold, rays), expected); });
    }
    for (const Growth growth : {Growth::kNone, Growth::kFull}) {
      TraceOptions options;
      options.growth = growth;
      expect_same(cast(*tests::snapshot_of(updates), rays, options), expected);
    }
    // One ray a batch, from the last to the first.
    const auto cold = tests::snapshot_of(updates);
    for (std::size_t i = rays.size(); i-- > rays.size() - 100;)
      expect_same(cast(*cold, {rays[i]}), {expected[i]});
  }
}

INSTANTIATE_TEST_SUITE_P(All, HierarchyInFrames,
                         testing::Values(Frames::kRigid, Frames::kSheared, Frames::kFar,
                                         Frames::kFlat));

TEST(LazyHierarchy, EightThreadsOpenAColdSceneAtOnce) {
  const auto updates = tests::random_hierarchy(2000, Frames::kRigid, 12);
  const std::vector<Ray> rays = tests::rays_through(*tests::snapshot_of(updates), 1500, 3);
  const std::vector<Hit> expected = cast(*tests::snapshot_of(updates), rays);
  for (int round = 0; round < 3; ++round) {
    const auto cold = tests::snapshot_of(updates);
    std::vector<std::vector<Hit>> hits(8);
    std::vector<std::thread> threads;
    for (auto& mine : hits) threads.emplace_back([&] { mine = cast(*cold, rays); });
    for (std::thread& thread : threads) thread.join();
    for (const auto& mine : hits) expect_same(mine, expected);
  }
}

TEST(LazyHierarchy, SelectionsOfGroupsThatAreNotOpened) {
  const auto updates = tests::random_hierarchy(500, Frames::kRigid, 21);
  const auto warm = tests::snapshot_of(updates);
  const std::vector<Ray> rays = tests::rays_through(*warm, 400, 5);
  tests::Random random(6);
  for (int round = 0; round < 20; ++round) {
    const model::NodeId root = round % 3 == 0 ? 0 : 1 + random.below(500);
    const std::vector<model::NodeId> excluded{1 + random.below(500), 1 + random.below(500)};
    tests::Filter filter;
    for (model::NodeId id = 1; id <= 500; ++id) {
      bool in = root == 0, out = false;
      for (model::NodeId at = id; at != 0; at = warm->find(at)->parent) {
        in = in || at == root;
        out = out || at == excluded[0] || at == excluded[1];
      }
      if (!in || out) filter.hidden.push_back(id);
    }
    const auto cold = tests::snapshot_of(updates);
    const auto selection = query::Selection::make(cold, root, excluded);
    ASSERT_TRUE(selection);
    TraceOptions options;
    options.selection = &*selection;
    const std::vector<Hit> hits = cast(*cold, rays, options);
    static const tests::BruteForce kOracle(warm);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto agreement = tests::compare(hits[i], kOracle.trace(rays[i], filter));
      ASSERT_NE(agreement, tests::Agreement::kMismatch) << i;
    }
  }
}

TEST(LazyHierarchy, FollowsUpdates) {
  tests::Random random(31);
  Scene scene;
  ASSERT_TRUE(scene.apply(tests::random_hierarchy(300, Frames::kRigid, 13)));
  for (int round = 0; round < 15; ++round) {
    const auto id = static_cast<model::NodeRef>(1 + random.below(300));
    const model::NodeId parent = random.below(300);
    std::vector<model::Update> updates{
        model::SetTransforms{{id}, {random_frame(random, Frames::kRigid)}}};
    if (scene.snapshot()->find(parent) != nullptr) {
      model::PutNode put;
      put.node = -1;
      put.parent = static_cast<model::NodeRef>(parent);
      put.parent_from_local = random_frame(random, Frames::kRigid, 30);
      put.mesh = tests::some_mesh(0);
      updates.emplace_back(put);
    }
    if (round % 4 == 3) updates.emplace_back(model::DeleteNode{id, true});
    if (!scene.apply(updates)) continue;
    const auto snapshot = scene.snapshot();
    const std::vector<Ray> rays = tests::rays_through(*snapshot, 300, 7);
    const auto compared = tests::compare(rays, cast(*snapshot, rays), tests::BruteForce(snapshot));
    EXPECT_TRUE(compared.clean()) << compared.report();
  }
}

/// Down onto the middle of the first square and of some others.
std::vector<Ray> rays_at_squares(std::size_t leaves, std::size_t count) {
  std::size_t side = 1;
  while (side * side < leaves) side *= 2;
  const std::size_t high = leaves / side;
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i * 7 % side) + 0.25;
    const double y = static_cast<double>(i * 5 % high) + 0.5;
    rays.push_back({{x, y, 3}, {0, 0, -1}});
  }
  return rays;
}

std::uint64_t placed_by_one_ray(std::size_t leaves, std::size_t fan) {
  const auto snapshot = tests::tiled_plane(leaves, fan);
  tbb::task_arena arena(1);
  arena.execute([&] {
    const std::vector<Hit> hits = cast(*snapshot, rays_at_squares(leaves, 1));
    EXPECT_EQ(hits[0].t, 3);
  });
  EXPECT_EQ(snapshot->trees().static_tree().size(), leaves);
  return snapshot->trees().static_tree().opened_members();
}

TEST(LazyHierarchy, OneRayOpensLittleOfALargeScene) {
  const std::uint64_t small = placed_by_one_ray(1 << 9, 16), large = placed_by_one_ray(1 << 17, 16);
  EXPECT_LE(small, (1u << 9) + 64);
  EXPECT_LT(large, 6000u);
  EXPECT_LT(placed_by_one_ray(1 << 17, 2), 6000u);
}

TEST(LazyHierarchy, AFlatSceneIsPlacedOnceAndKeptInRuns) {
  constexpr std::size_t kLeaves = 1 << 17;
  const auto snapshot = tests::tiled_plane(kLeaves, 0);
  EXPECT_LE(snapshot->trees().static_tree().coarsest().size(), kMaxUnclustered);
  EXPECT_EQ(snapshot->trees().static_tree().opened_members(), kLeaves + 1);
  tbb::task_arena arena(1);
  arena.execute([&] {
    Hit hit;
    const auto stats = trace(*snapshot, rays_at_squares(kLeaves, 1), {&hit, 1}, {});
    ASSERT_TRUE(stats);
    EXPECT_LT(stats->touches, kLeaves / 4);
    for (const Hit& each : cast(*snapshot, rays_at_squares(kLeaves, 500))) ASSERT_EQ(each.t, 3);
  });
  EXPECT_EQ(snapshot->trees().static_tree().opened_members(), kLeaves + 1);
}

TEST(LazyHierarchy, SummariesOpenNothing) {
  const auto snapshot = tests::tiled_plane(1 << 12, 16);
  EXPECT_EQ(summarize(*snapshot).instances, 1u << 12);
  EXPECT_EQ(summarize_build(*snapshot).instances_total, 1u << 12);
  EXPECT_EQ(snapshot->shared_trees().static_tree()->instances_so_far(), nullptr);
  (void)cast(*snapshot, rays_at_squares(1 << 12, 1));
  const std::uint64_t placed = snapshot->trees().static_tree().opened_members();
  EXPECT_EQ(summarize_build(*snapshot).instances_entered, 1u);
  EXPECT_EQ(snapshot->trees().static_tree().opened_members(), placed);
  ASSERT_TRUE(build_all(*snapshot));
  EXPECT_EQ(summarize_build(*snapshot).instances_entered, 1u << 12);
}

TEST(BuildAll, ReportsItsProgress) {
  const auto snapshot = tests::snapshot_of(tests::random_hierarchy(200, Frames::kRigid, 1));
  query::BuildProgress progress;
  EXPECT_EQ(progress.share(), 0);
  ASSERT_TRUE(build_all(*snapshot, nullptr, &progress));
  const revision::SceneSummary scene = summarize(*snapshot);
  EXPECT_EQ(progress.meshes_total, scene.meshes);
  EXPECT_EQ(progress.meshes_done, scene.meshes);
  EXPECT_EQ(progress.triangles_total, scene.triangles_unique);
  EXPECT_EQ(progress.triangles_done, scene.triangles_unique);
  EXPECT_EQ(progress.share(), 1);
  const std::atomic<bool> cancelled{true};
  query::BuildProgress none;
  EXPECT_FALSE(build_all(*tests::tiled_plane(64, 4), &cancelled, &none));
  EXPECT_EQ(none.meshes_total, 1u);
  EXPECT_EQ(none.meshes_done, 0u);
}

}  // namespace
}  // namespace sightline::scenegraph::instances
