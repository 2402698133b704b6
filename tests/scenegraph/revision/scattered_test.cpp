// Laws of moves all over a scene: they cost what they change.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "accel/lazy/lazy_tree.h"
#include "tests/scenegraph/revision/row_of_nodes.h"
#include "tests/support/random.h"

namespace sightline::scenegraph::revision {
namespace {

using accel::geometry::Ray;
using instances::SceneTree;

constexpr int kMoved = 100;  // A revision

/// Any nodes of a row, each near its place.
model::SetTransforms move_some(tests::Random& random, int nodes) {
  model::SetTransforms set;
  for (int i = 0; i < kMoved; ++i) {
    const auto id = static_cast<model::NodeRef>(1 + random.below(static_cast<std::size_t>(nodes)));
    set.nodes.push_back(id);
    set.parent_from_local.push_back(at(10.0 * static_cast<double>(id), random.uniform(-1, 1)));
  }
  return set;
}

std::vector<Ray> some_rays(tests::Random& random, int nodes, int count) {
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    const double x = 10.0 * static_cast<double>(random.below(static_cast<std::size_t>(nodes)));
    rays.push_back({{x + 0.1, 0.2, 9}, {0, 0, -1}});
  }
  return rays;
}

/// What rays touch in dynamic trees, in one revision, on average.
std::uint64_t touches_of_a_revision(int nodes, int revisions) {
  Scene scene;
  add_row(scene, nodes);
  tests::Random random(7);
  hits_in(*scene.snapshot(), some_rays(random, nodes, 64));
  std::uint64_t touches = 0;
  for (int round = 0; round < revisions; ++round) {
    const auto applied = scene.apply({move_some(random, nodes)});
    EXPECT_TRUE(applied);
    TraceStats stats;
    hits_in(*scene.snapshot(), some_rays(random, nodes, 64), &stats);
    touches += stats.dynamic_touches;
    if (applied->merge_trees) scene.merge_trees();
  }
  return touches / static_cast<std::uint64_t>(revisions);
}

TEST(ScatteredMoves, DoNotCostMoreInLargerScenesOrLater) {
  const std::uint64_t few = touches_of_a_revision(4000, 20);
  EXPECT_LE(touches_of_a_revision(4000, 80), few + kMoved);
  EXPECT_LE(touches_of_a_revision(16000, 20), few + kMoved);
}

TEST(ScatteredMoves, AreFoundWithoutGrowingATreeForFewRays) {
  Scene scene;
  add_row(scene, 4000);
  tests::Random random(8);
  hits_in(*scene.snapshot(), some_rays(random, 4000, 4000));
  ASSERT_TRUE(scene.apply({move_some(random, 4000)}));
  TraceStats stats;
  hits_in(*scene.snapshot(), some_rays(random, 4000, 16), &stats);
  EXPECT_EQ(stats.dynamic_touches, 0u);
  expect_as_oracle(scene.snapshot(), 1);
}

TEST(ScatteredMoves, GrowATreeOnceRaysHavePaidForIt) {
  Scene scene;
  add_row(scene, 4000);
  tests::Random random(9);
  hits_in(*scene.snapshot(), some_rays(random, 4000, 4000));
  ASSERT_TRUE(scene.apply({move_some(random, 4000)}));
  const auto& tree = scene.snapshot()->trees().dynamic().front().instances;
  std::uint64_t touches = 0;
  for (int batch = 0; batch < 100 && touches == 0; ++batch) {
    TraceStats stats;
    hits_in(*scene.snapshot(), some_rays(random, 4000, 4000), &stats);
    touches = stats.dynamic_touches;
  }
  EXPECT_GT(touches, 0u);
  EXPECT_FALSE(accel::kdtree::load(tree.tree().root()).is_deferred());
  expect_as_oracle(scene.snapshot(), 2);
}

/// The built-only walks of the server's fast path see what is searched.
TEST(ScatteredMoves, AreSeenByWalksThatBuildNothing) {
  Scene scene;
  add_row(scene, 4000);
  tests::Random random(10);
  const std::vector<Ray> rays = some_rays(random, 4000, 500);
  ASSERT_TRUE(scene.apply({move_some(random, 4000)}));
  hits_in(*scene.snapshot(), rays);
  ASSERT_TRUE(scene.apply({move_some(random, 4000)}));
  const auto lazily = hits_in(*scene.snapshot(), rays);
  std::vector<accel::geometry::Hit> built(rays.size());
  ASSERT_TRUE(trace(*scene.snapshot(), rays, built, {.growth = Growth::kBuiltOnly}));
  EXPECT_TRUE(std::equal(lazily.begin(), lazily.end(), built.begin(), built.end(),
                         [](const auto& a, const auto& b) {
                           return a.t == b.t && a.node == b.node && a.work == b.work;
                         }));
}

/// What was taken over is let go when the new tree is opened.
TEST(ScatteredMoves, KeepNoTreesThatWereReplaced) {
  Scene scene;
  add_row(scene, 1000);
  tests::Random random(11);
  std::vector<std::weak_ptr<const SceneTree>> trees;
  for (int round = 0; round < 20; ++round) {
    hits_in(*scene.snapshot(), some_rays(random, 1000, 10));
    ASSERT_TRUE(scene.apply({move_some(random, 1000)}));
    trees.push_back(scene.snapshot()->shared_trees().levels.back().tree);
  }
  hits_in(*scene.snapshot(), some_rays(random, 1000, 10));
  const auto& levels = scene.snapshot()->shared_trees().levels;
  const auto alive = std::ranges::count_if(trees, [](const auto& tree) { return !tree.expired(); });
  EXPECT_EQ(static_cast<std::size_t>(alive), levels.size() - 1);
}

/// However many revisions no ray sees.
TEST(ScatteredMoves, TakeOverFewTreesThatRaysHaveOpened) {
  Scene scene;
  add_row(scene, 1000);
  tests::Random random(12);
  for (int round = 0; round < 50; ++round) {
    if (round < 3) hits_in(*scene.snapshot(), some_rays(random, 1000, 10));
    ASSERT_TRUE(scene.apply({move_some(random, 1000)}));
    const auto moved = scene.snapshot()->shared_trees().levels.back().tree->moved();
    ASSERT_NE(moved, nullptr);
    EXPECT_LE(moved->parts.size(), 3u);
    EXPECT_LE(moved->candidates->size(), 3000u);
  }
  expect_as_oracle(scene.snapshot(), 3);
}

/// A root of a tree that is taken over has got a child, and so is no single instance any more.
TEST(ScatteredMoves, TakeOverNoInstanceThatHasBecomeAGroup) {
  Scene scene;
  add_row(scene, 300);
  hits_in(*scene.snapshot(), {{{0, 0, 9}, {0, 0, -1}}});
  model::PutNode empty;
  empty.node = -1;
  empty.parent = 5;
  model::SetTransforms all;
  for (model::NodeRef id = 1; id <= 100; ++id) {
    all.nodes.push_back(id);
    all.parent_from_local.push_back(at(10.0 * static_cast<double>(id), 0.1));
  }
  ASSERT_TRUE(scene.apply({all, empty}));
  hits_in(*scene.snapshot(), {{{0, 0, 9}, {0, 0, -1}}});
  ASSERT_TRUE(scene.apply({mesh_node(301, 3, model::Mobility::kStatic, 5)}));
  expect_as_oracle(scene.snapshot(), 4);
  EXPECT_EQ(hits_in(*scene.snapshot(), {{{53.1, 0.3, 9}, {0, 0, -1}}})[0].node, 301u);
  ASSERT_TRUE(scene.apply({mesh_node(-1, 6, model::Mobility::kStatic, 5)}));
  expect_as_oracle(scene.snapshot(), 5);
}

}  // namespace
}  // namespace sightline::scenegraph::revision
