// Dynamic and static nodes, and sharing between revisions.
#include "scenegraph/revision/mobility.h"

#include <gtest/gtest.h>

#include "tests/scenegraph/revision/row_of_nodes.h"

namespace sightline::scenegraph::revision {
namespace {

using accel::geometry::Ray;

const instances::Level& static_level(const Snapshot& snapshot) {
  return snapshot.shared_trees().levels.front();
}

std::size_t count_dynamic(const Snapshot& snapshot) {
  return instances::topmost_dynamic_roots(snapshot.hierarchy()).size();
}

TEST(DynamicRoots, StartFromTheDeclaredMobility) {
  Scene scene;
  ASSERT_TRUE(scene.apply({mesh_node(-1, 0), mesh_node(-2, 10, model::Mobility::kRigid),
                           mesh_node(-3, 20, model::Mobility::kDeforming),
                           mesh_node(-4, 30, model::Mobility::kStatic, -2),
                           mesh_node(-5, 40, model::Mobility::kRigid, -2)}));
  const auto snapshot = scene.snapshot();
  EXPECT_EQ(snapshot->trees().static_tree().size(), 1u);
  ASSERT_EQ(snapshot->trees().dynamic().size(), 1u);
  EXPECT_EQ(snapshot->trees().dynamic()[0].instances.size(), 4u);
  EXPECT_EQ(count_dynamic(*snapshot), 2u);  // Node 5 belongs to the subtree of node 2
  EXPECT_EQ(summarize_build(*snapshot).dynamic_instances, 4u);
  EXPECT_EQ(summarize_build(*snapshot).static_instances, 1u);
  expect_as_oracle(snapshot, 1);
}

TEST(DynamicRoots, AreNewOrChangedNodesAfterTheFirstRay) {
  Scene scene;
  add_row(scene, 100);
  ASSERT_TRUE(scene.apply({model::SetTransforms{{3}, {at(35)}}}));
  EXPECT_TRUE(scene.snapshot()->trees().dynamic().empty());
  expect_as_oracle(scene.snapshot(), 2);
  ASSERT_TRUE(scene.apply({model::SetTransforms{{3, 4}, {at(36), at(46)}}, mesh_node(-1, 5)}));
  const auto snapshot = scene.snapshot();
  EXPECT_EQ(count_dynamic(*snapshot), 3u);
  EXPECT_EQ(static_level(*snapshot).left, 2u);
  ASSERT_EQ(snapshot->trees().dynamic().size(), 1u);
  EXPECT_EQ(snapshot->trees().dynamic()[0].instances.size(), 3u);
  expect_as_oracle(snapshot, 3);
  ASSERT_TRUE(scene.apply({model::DeleteNode{5}}));
  EXPECT_EQ(static_level(*scene.snapshot()).left, 3u);
  EXPECT_EQ(count_dynamic(*scene.snapshot()), 3u);
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
  hits_in(*scene.snapshot(), rays, &stats);
  EXPECT_GT(stats.touches, stats.dynamic_touches);
  const auto static_tree = scene.snapshot()->shared_trees().static_tree();
  for (int frame = 1; frame < 20; ++frame) {
    ASSERT_TRUE(scene.apply({model::SetTransforms{{id}, {at(3.0 * frame)}}}));
    hits_in(*scene.snapshot(), rays, &stats);
    EXPECT_EQ(scene.snapshot()->shared_trees().static_tree(), static_tree);
    EXPECT_EQ(stats.touches + stats.touches_prepare, stats.dynamic_touches);
    hits_in(*scene.snapshot(), rays, &stats);
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
  hits_in(*scene.snapshot(), {{{0, 0, 9}, {0, 0, -1}}});
  ASSERT_TRUE(scene.apply({model::SetTransforms{{1}, {at(3, 4)}}}));
  EXPECT_EQ(scene.snapshot()->trees().dynamic()[0].instances.size(), 49u);
  expect_as_oracle(scene.snapshot(), 6);
  // A node that is removed from the group stays dynamic by itself.
  model::PutNode out = mesh_node(2, -5);
  ASSERT_TRUE(scene.apply({out}));
  EXPECT_EQ(count_dynamic(*scene.snapshot()), 2u);
  expect_as_oracle(scene.snapshot(), 7);
  ASSERT_TRUE(scene.apply({model::DeleteNode{1, true}}));
  EXPECT_EQ(count_dynamic(*scene.snapshot()), 1u);
  EXPECT_EQ(summarize(*scene.snapshot()).instances, 1u);
  expect_as_oracle(scene.snapshot(), 8);
}

TEST(DynamicRoots, MoveWithAStaticGroupThatNoRayHasSeen) {
  Scene scene;
  model::PutNode group;
  group.node = -1;
  ASSERT_TRUE(scene.apply({group, mesh_node(-2, 10, model::Mobility::kRigid, -1)}));
  ASSERT_TRUE(scene.apply({model::SetTransforms{{1}, {at(50)}}}));
  EXPECT_EQ(scene.snapshot()->trees().dynamic()[0].instances.size(), 1u);
  expect_as_oracle(scene.snapshot(), 11);
  const auto hits = hits_in(*scene.snapshot(), {{{60.1, 0.2, 9}, {0, 0, -1}}});
  EXPECT_EQ(hits[0].node, 2u);
}

TEST(DynamicRoots, AreNotChangedByNewNames) {
  Scene scene;
  add_row(scene, 10);
  hits_in(*scene.snapshot(), {{{0, 0, 9}, {0, 0, -1}}});
  const instances::SceneTrees before = scene.snapshot()->shared_trees();
  model::PutNode renamed = mesh_node(4, 40);
  renamed.name = "renamed";
  ASSERT_TRUE(scene.apply({renamed}));
  EXPECT_EQ(scene.snapshot()->find(4)->name, "renamed");
  EXPECT_EQ(scene.snapshot()->shared_trees().static_tree(), before.static_tree());
  EXPECT_EQ(scene.snapshot()->shared_trees().levels.size(), before.levels.size());
}

}  // namespace
}  // namespace sightline::scenegraph::revision
