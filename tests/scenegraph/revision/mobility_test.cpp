// Dynamic and static nodes, and sharing between revisions.
#include "scenegraph/revision/mobility.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <thread>

#include "scenegraph/query/selection.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"

namespace sightline::scenegraph::revision {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;

model::Affine at(double x, double y = 0, double z = 0) {
  return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}

model::PutNode mesh_node(model::NodeRef alias, double x,
                         model::Mobility mobility = model::Mobility::kStatic,
                         model::NodeRef parent = 0) {
  model::PutNode put;
  put.node = alias;
  put.parent = parent;
  put.parent_from_local = at(x);
  put.mesh = tests::some_mesh(0);
  put.mobility = mobility;
  return put;
}

/// Static nodes 1 .. count in a row.
void add_row(Scene& scene, int count) {
  std::vector<model::Update> updates;
  for (int i = 1; i <= count; ++i) updates.emplace_back(mesh_node(-i, 10.0 * i));
  ASSERT_TRUE(scene.apply(updates));
}

std::vector<Hit> cast(const Snapshot& snapshot, const std::vector<Ray>& rays,
                      TraceStats* stats = nullptr) {
  std::vector<Hit> hits(rays.size());
  const auto traced = trace(snapshot, rays, hits, {});
  EXPECT_TRUE(traced);
  if (stats != nullptr) *stats = *traced;
  return hits;
}

void expect_as_oracle(const std::shared_ptr<const Snapshot>& snapshot, std::uint64_t seed) {
  const std::vector<Ray> rays = tests::rays_through(*snapshot, 300, seed);
  const tests::BruteForce oracle(snapshot);
  const auto compared = tests::compare(rays, cast(*snapshot, rays), oracle);
  EXPECT_TRUE(compared.clean()) << compared.report();
}

TEST(DynamicRoots, StartFromTheDeclaredMobility) {
  Scene scene;
  ASSERT_TRUE(scene.apply({mesh_node(-1, 0), mesh_node(-2, 10, model::Mobility::kRigid),
                           mesh_node(-3, 20, model::Mobility::kDeforming),
                           mesh_node(-4, 30, model::Mobility::kStatic, -2),
                           mesh_node(-5, 40, model::Mobility::kRigid, -2)}));
  const auto snapshot = scene.snapshot();
  EXPECT_EQ(snapshot->trees().static_tree.size(), 1u);
  EXPECT_EQ(snapshot->trees().dynamic_tree.size(), 4u);
  EXPECT_EQ(snapshot->hierarchy().dynamic_roots.size(),
            2u);  // Node 5 belongs to the subtree of node 2
  EXPECT_EQ(summarize_build(*snapshot).dynamic_instances, 4u);
  EXPECT_EQ(summarize_build(*snapshot).static_instances, 1u);
  expect_as_oracle(snapshot, 1);
}

TEST(DynamicRoots, AreNewOrChangedNodesAfterTheFirstRay) {
  Scene scene;
  add_row(scene, 100);
  ASSERT_TRUE(scene.apply({model::SetTransforms{{3}, {at(35)}}}));
  EXPECT_EQ(scene.snapshot()->hierarchy().dynamic_roots.size(), 0u);
  expect_as_oracle(scene.snapshot(), 2);
  ASSERT_TRUE(scene.apply({model::SetTransforms{{3, 4}, {at(36), at(46)}}, mesh_node(-1, 5)}));
  const auto snapshot = scene.snapshot();
  EXPECT_EQ(snapshot->hierarchy().dynamic_roots.size(), 3u);
  EXPECT_EQ(snapshot->shared_trees().removed->nodes().size(), 2u);
  EXPECT_EQ(snapshot->trees().dynamic_tree.size(), 3u);
  expect_as_oracle(snapshot, 3);
  ASSERT_TRUE(scene.apply({model::DeleteNode{5}}));
  EXPECT_EQ(scene.snapshot()->shared_trees().removed->nodes().size(), 3u);
  EXPECT_EQ(scene.snapshot()->shared_trees().dynamic_tree, snapshot->shared_trees().dynamic_tree);
  expect_as_oracle(scene.snapshot(), 4);
}

TEST(DynamicRoots, DoNotChangeTheStaticTree) {
  Scene scene;
  add_row(scene, 500);
  ASSERT_TRUE(scene.apply({mesh_node(-1, 0, model::Mobility::kRigid)}));
  const auto id = static_cast<model::NodeRef>(501);
  std::vector<Ray> rays;
  for (int i = 0; i <= 500; ++i) rays.push_back({{10.0 * i + 0.1, 0.2, 9}, {0, 0, -1}});
  TraceStats stats;
  cast(*scene.snapshot(), rays, &stats);
  EXPECT_GT(stats.touches, stats.dynamic_touches);
  const auto static_tree = scene.snapshot()->shared_trees().static_tree;
  for (int frame = 1; frame < 20; ++frame) {
    ASSERT_TRUE(scene.apply({model::SetTransforms{{id}, {at(3.0 * frame)}}}));
    cast(*scene.snapshot(), rays, &stats);
    EXPECT_EQ(scene.snapshot()->shared_trees().static_tree, static_tree);
    EXPECT_EQ(stats.touches + stats.touches_prepare, stats.dynamic_touches);
    cast(*scene.snapshot(), rays, &stats);
    EXPECT_EQ(stats.touches, 0u);
  }
  expect_as_oracle(scene.snapshot(), 5);
}

TEST(DynamicRoots, OfAGroupIncludeAllNodesBelow) {
  Scene scene;
  model::PutNode group;
  group.node = -1;
  std::vector<model::Update> updates{group};
  for (int i = 2; i <= 50; ++i)
    updates.emplace_back(mesh_node(-i, 10.0 * i, model::Mobility::kStatic, -1));
  ASSERT_TRUE(scene.apply(updates));
  cast(*scene.snapshot(), {{{0, 0, 9}, {0, 0, -1}}});
  ASSERT_TRUE(scene.apply({model::SetTransforms{{1}, {at(3, 4)}}}));
  EXPECT_EQ(scene.snapshot()->trees().dynamic_tree.size(), 49u);
  expect_as_oracle(scene.snapshot(), 6);
  // A node that is removed from the group stays dynamic by itself.
  model::PutNode out = mesh_node(2, -5);
  ASSERT_TRUE(scene.apply({out}));
  EXPECT_EQ(scene.snapshot()->hierarchy().dynamic_roots.size(), 2u);
  EXPECT_EQ(scene.snapshot()->trees().dynamic_tree.size(), 49u);
  expect_as_oracle(scene.snapshot(), 7);
  ASSERT_TRUE(scene.apply({model::DeleteNode{1, true}}));
  EXPECT_EQ(scene.snapshot()->trees().dynamic_tree.size(), 1u);
  EXPECT_EQ(summarize(*scene.snapshot()).instances, 1u);
  expect_as_oracle(scene.snapshot(), 8);
}

TEST(DynamicRoots, MoveWithAStaticGroupThatNoRayHasSeen) {
  Scene scene;
  model::PutNode group;
  group.node = -1;
  ASSERT_TRUE(scene.apply({group, mesh_node(-2, 10, model::Mobility::kRigid, -1)}));
  ASSERT_TRUE(scene.apply({model::SetTransforms{{1}, {at(50)}}}));
  EXPECT_EQ(scene.snapshot()->trees().dynamic_tree.size(), 1u);
  expect_as_oracle(scene.snapshot(), 11);
  const auto hits = cast(*scene.snapshot(), {{{60.1, 0.2, 9}, {0, 0, -1}}});
  EXPECT_EQ(hits[0].node, 2u);
}

TEST(DynamicRoots, AreNotChangedByNewNames) {
  Scene scene;
  add_row(scene, 10);
  cast(*scene.snapshot(), {{{0, 0, 9}, {0, 0, -1}}});
  const instances::SceneTrees before = scene.snapshot()->shared_trees();
  model::PutNode renamed = mesh_node(4, 40);
  renamed.name = "renamed";
  ASSERT_TRUE(scene.apply({renamed}));
  EXPECT_EQ(scene.snapshot()->find(4)->name, "renamed");
  EXPECT_EQ(scene.snapshot()->shared_trees().static_tree, before.static_tree);
  EXPECT_EQ(scene.snapshot()->shared_trees().dynamic_tree, before.dynamic_tree);
}

TEST(Settle, ReturnsRestingNodesToTheStaticTree) {
  Scene scene;
  add_row(scene, 300);
  cast(*scene.snapshot(), {{{0, 0, 9}, {0, 0, -1}}});
  ASSERT_TRUE(scene.apply({model::SetTransforms{{7, 8, 9}, {at(75), at(85), at(95)}}}));
  bool due = false;
  for (std::uint64_t round = 0; round < 4 * SettlePolicy::kRevisions && !due; ++round) {
    const auto applied =
        scene.apply({model::SetTransforms{{10}, {at(100 + static_cast<double>(round))}}});
    ASSERT_TRUE(applied);
    due = applied->rebuild_static;
  }
  ASSERT_TRUE(due);
  EXPECT_EQ(scene.snapshot()->trees().dynamic_tree.size(), 4u);
  const auto before = scene.snapshot();
  expect_as_oracle(before, 9);
  scene.rebuild_static();
  const auto after = scene.snapshot();
  EXPECT_EQ(after->revision(), before->revision());
  EXPECT_EQ(after->trees().dynamic_tree.size(), 1u);
  EXPECT_EQ(after->shared_trees().removed, nullptr);
  expect_as_oracle(after, 9);
  ASSERT_TRUE(scene.apply({model::SetTransforms{{8}, {at(1)}}}));
  EXPECT_EQ(scene.snapshot()->trees().dynamic_tree.size(), 2u);
  expect_as_oracle(scene.snapshot(), 10);
}

TEST(Settle, ANewStaticTreeIsDueOnceHalfOfTheSceneIsDeleted) {
  Scene scene;
  add_row(scene, 20);
  cast(*scene.snapshot(), {{{0, 0, 9}, {0, 0, -1}}});
  std::vector<model::Update> deleted;
  for (model::NodeRef id = 1; id <= 10; ++id) deleted.emplace_back(model::DeleteNode{id});
  ASSERT_TRUE(scene.apply(deleted));
  EXPECT_NE(scene.snapshot()->shared_trees().removed, nullptr);
  bool due = false;
  for (std::uint64_t round = 0; round < SettlePolicy::kRevisions && !due; ++round) {
    const auto applied = scene.apply({model::SetTransforms{{11}, {at(200)}}});
    ASSERT_TRUE(applied);
    due = applied->rebuild_static;
  }
  EXPECT_TRUE(due);
  scene.rebuild_static();
  EXPECT_EQ(scene.snapshot()->shared_trees().removed, nullptr);
}

TEST(Settle, BuildsTheNewTreeWhereTheOldOneWasBuilt) {
  Scene scene;
  add_row(scene, 3000);
  std::vector<Ray> rays;
  for (int i = 0; i <= 3000; ++i) rays.push_back({{10.0 * i + 0.1, 0.2, 9}, {0, 0, -1}});
  TraceStats cold, rebuilt;
  cast(*scene.snapshot(), rays, &cold);
  ASSERT_TRUE(scene.apply({model::SetTransforms{{7}, {at(75)}}}));
  scene.rebuild_static();
  cast(*scene.snapshot(), rays, &rebuilt);
  // Not all of them: planes differ, and a cell may lie between the sampled positions.
  EXPECT_LT(10 * (rebuilt.touches - rebuilt.dynamic_touches), cold.touches);
}

TEST(Settle, OfATreeWithoutRaysDoesNothing) {
  Scene scene;
  add_row(scene, 10);
  const auto before = scene.snapshot();
  scene.rebuild_static();
  EXPECT_EQ(scene.snapshot(), before);
}

/// A node moves after its tree was dropped, while the tree that replaces it is made.
TEST(Settle, MissesNoChangeWhileTreesAreDropped) {
  std::vector<Ray> here, there;
  for (int i = 0; i < 10; ++i) {
    here.push_back({{50.05 + 0.1 * i, 0.2, 9}, {0, 0, -1}});
    there.push_back({{-49.95 + 0.1 * i, 0.2, 9}, {0, 0, -1}});
  }
  for (int round = 0; round < 40; ++round) {
    Scene scene;
    add_row(scene, 3000);
    const std::vector<Hit> before = cast(*scene.snapshot(), here);
    ASSERT_EQ(before.front().node, 5u);
    std::atomic<bool> begun{false};
    std::thread rebuilding([&] {
      begun = true;
      scene.rebuild_static();
    });
    while (!begun) std::this_thread::yield();
    for (int i = 0; i < 10 * round; ++i) std::this_thread::yield();
    scene.drop_trees();
    ASSERT_TRUE(scene.apply({model::SetTransforms{{5}, {at(-50)}}}));
    rebuilding.join();
    const std::vector<Hit> left = cast(*scene.snapshot(), here);
    const std::vector<Hit> moved = cast(*scene.snapshot(), there);
    for (std::size_t i = 0; i < here.size(); ++i) {
      ASSERT_NE(left[i].node, 5u) << "in round " << round;
      ASSERT_EQ(moved[i].node, before[i].node) << "in round " << round;
    }
  }
}

/// All together: groups and instances of all mobilities change, some of them are seen by rays, and
/// static trees are rebuilt meanwhile.
TEST(Settle, KeepsHitsCorrectAmongAnyUpdates) {
  tests::Random random(31);
  for (const tests::Frames frames : {tests::Frames::kRigid, tests::Frames::kFar}) {
    Scene scene;
    ASSERT_TRUE(scene.apply(tests::random_hierarchy(150, frames, 8)));
    for (std::uint64_t round = 0; round < 120; ++round) {
      std::vector<model::NodeRef> ids;
      scene.snapshot()->nodes().for_each(
          [&](model::NodeId id, const std::shared_ptr<const model::Node>&) {
            ids.push_back(static_cast<model::NodeRef>(id));
          });
      const auto any = [&] { return ids[random.below(ids.size())]; };
      std::vector<model::Update> updates;
      model::PutNode put = mesh_node(random.below(2) == 0 ? -1 : any(), 0,
                                     static_cast<model::Mobility>(random.below(3)),
                                     random.below(4) == 0 ? 0 : any());
      put.parent_from_local = tests::random_frame(random, frames);
      updates.emplace_back(put);
      updates.emplace_back(model::SetTransforms{{any()}, {tests::random_frame(random, frames)}});
      if (ids.size() > 100) updates.emplace_back(model::DeleteNode{any(), random.below(3) == 0});
      (void)scene.apply(updates);
      if (random.below(3) == 0) scene.rebuild_static();
      const auto snapshot = scene.snapshot();
      const std::size_t gone = snapshot->shared_trees().removed == nullptr
                                   ? 0
                                   : snapshot->shared_trees().removed->nodes().size();
      const hierarchy::NodeSummary all = snapshot->hierarchy().summary(0);
      ASSERT_GE(snapshot->trees().size(), all.instances);
      if (gone == 0) {
        ASSERT_EQ(snapshot->trees().size(), all.instances);
      }
      if (round % 2 == 0) expect_as_oracle(snapshot, round);
      if (HasFailure()) return;
    }
  }
}

}  // namespace
}  // namespace sightline::scenegraph::revision
