// Trees that are made for revisions, and merged.
#include "scenegraph/revision/levels.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/scenegraph/revision/row_of_nodes.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::scenegraph::revision {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;

/// Every tree is large, and few members are merged at once: so a few nodes make several trees.
constexpr MergeRule kManySmall{.small_tree = 0, .at_once = 8, .many_trees = 8};

std::vector<Ray> rays_down_the_row(int count) {
  std::vector<Ray> rays;
  for (int i = 0; i <= count; ++i) rays.push_back({{10.0 * i + 0.1, 0.2, 9}, {0, 0, -1}});
  return rays;
}

void cast_one(const Scene& scene) { hits_in(*scene.snapshot(), {{{0, 0, 9}, {0, 0, -1}}}); }

std::vector<std::size_t> sizes_of_dynamic(const Snapshot& snapshot) {
  std::vector<std::size_t> sizes;
  const instances::OpenTrees trees = snapshot.trees();
  for (const instances::OpenTree& tree : trees.dynamic()) sizes.push_back(tree.instances.size());
  return sizes;
}

/// Moves `count` nodes from number `first` on, to another transform with each round.
model::SetTransforms move(model::NodeRef first, int count, int round) {
  model::SetTransforms set;
  for (int i = 0; i < count; ++i) {
    set.nodes.push_back(first + i);
    set.parent_from_local.push_back(at(10.0 * static_cast<double>(first + i), 0.01 * (round + 1)));
  }
  return set;
}

TEST(Levels, ASmallTreeIsPartOfThatOfTheNextRevision) {
  Scene scene;
  add_row(scene, 100);
  for (int round = 0; round < 5; ++round) {
    cast_one(scene);
    ASSERT_TRUE(scene.apply({move(1 + 10 * round, 10, round)}));
  }
  EXPECT_EQ(sizes_of_dynamic(*scene.snapshot()), std::vector<std::size_t>{50});
  expect_as_oracle(scene.snapshot(), 1);
}

TEST(Levels, ALargeTreeIsKept) {
  Scene scene;
  add_row(scene, 1000);
  cast_one(scene);
  ASSERT_TRUE(scene.apply({move(1, 300, 0)}));
  cast_one(scene);
  const auto large = scene.snapshot()->shared_trees().levels.at(1).tree;
  for (int round = 0; round < 5; ++round) {
    ASSERT_TRUE(scene.apply({move(500, 10, round)}));
    cast_one(scene);
    EXPECT_EQ(scene.snapshot()->shared_trees().levels.at(1).tree, large);
  }
  EXPECT_EQ(sizes_of_dynamic(*scene.snapshot()), (std::vector<std::size_t>{300, 10}));
  expect_as_oracle(scene.snapshot(), 2);
}

TEST(Levels, NodesThatAlwaysMoveMakeOneTree) {
  Scene scene;
  add_row(scene, 1000);
  for (int round = 0; round < 10; ++round) {
    cast_one(scene);
    ASSERT_TRUE(scene.apply({move(1, 400, round)}));
    EXPECT_EQ(sizes_of_dynamic(*scene.snapshot()), std::vector<std::size_t>{400});
  }
  expect_as_oracle(scene.snapshot(), 3);
}

/// Without rays between revisions, no tree has cost anything.
TEST(Levels, TreesThatNoRayOpenedAreNotKept) {
  Scene scene;
  add_row(scene, 1000);
  cast_one(scene);
  for (int round = 0; round < 3; ++round)
    ASSERT_TRUE(scene.apply({move(1 + 300 * round, 300, round)}));
  EXPECT_EQ(sizes_of_dynamic(*scene.snapshot()), std::vector<std::size_t>{900});
  expect_as_oracle(scene.snapshot(), 4);
}

/// Each tree holds more than the newer ones together, about.
TEST(Levels, TheirNumberGrowsWithTheLogarithm) {
  constexpr int kRounds = 200;
  Scene scene(MergeRule{.small_tree = 0, .at_once = 100'000, .many_trees = 100});
  add_row(scene, 2 * kRounds);
  std::uint64_t opened = 0;
  for (int round = 0; round < kRounds; ++round) {
    cast_one(scene);
    const auto newest = scene.snapshot()->trees().all().back();
    if (round > 0) opened += newest.instances.opened_members();
    ASSERT_TRUE(scene.apply({move(1 + 2 * round, 2, round)}));
    EXPECT_LE(scene.snapshot()->shared_trees().levels.size(), 18u);
  }
  EXPECT_LE(opened, 2u * kRounds * 8);
  expect_as_oracle(scene.snapshot(), 5);
}

TEST(Levels, ThereAreFewEvenIfNoneIsMergedInTheBackground) {
  Scene scene(MergeRule{.small_tree = 0, .at_once = 2, .many_trees = 4});
  add_row(scene, 400);
  for (int round = 0; round < 200; ++round) {
    cast_one(scene);
    ASSERT_TRUE(scene.apply({move(1 + 2 * round, 2, round)}));
    EXPECT_LE(scene.snapshot()->shared_trees().levels.size(), 20u);
  }
  expect_as_oracle(scene.snapshot(), 6);
}

/// The static merge is published while trees that are older than it wait for theirs: their
/// hierarchies still tell of changes that are static by now.
TEST(Merge, ADynamicOneAfterAStaticOneKeepsNodesBelowOnesThatBecameStatic) {
  Scene scene(kManySmall);
  std::vector<model::Update> updates;
  model::PutNode group;
  group.node = -1;
  updates.emplace_back(group);
  for (int i = 2; i <= 11; ++i)
    updates.emplace_back(mesh_node(-i, 10.0 * i, model::Mobility::kStatic, -1));
  for (int i = 12; i <= 40; ++i) updates.emplace_back(mesh_node(-i, 10.0 * i));
  ASSERT_TRUE(scene.apply(updates));
  const auto revise = [&](const model::SetTransforms& set) {
    cast_one(scene);
    ASSERT_TRUE(scene.apply({set}));
    cast_one(scene);
  };
  revise({{1}, {at(0, 0.3)}});  // the group, and all below it
  const auto base = scene.snapshot();
  revise(move(20, 8, 0));
  revise(move(2, 4, 1));  // some of those below
  revise(move(30, 2, 2));
  ASSERT_EQ(scene.snapshot()->shared_trees().levels.size(), 5U);
  const LevelRange resting{0, 2}, later{1, 3};
  const auto with_static = with_merged(*scene.snapshot(), *base, resting, merged(*base, resting));
  expect_as_oracle(with_static, 11);
  const auto with_both =
      with_merged(*with_static, *with_static, later, merged(*with_static, later));
  ASSERT_EQ(with_both->shared_trees().levels.size(), 3U);
  expect_as_oracle(with_both, 12);
}

TEST(Merge, BringsRestingNodesBackToTheStaticTree) {
  constexpr int kNodes = 40;
  Scene scene(kManySmall);
  add_row(scene, kNodes);
  const auto old = scene.snapshot()->shared_trees().static_tree();
  for (int round = 0; round < kNodes; ++round) {
    cast_one(scene);
    ASSERT_TRUE(scene.apply({move(1 + round, 1, round)}));
    cast_one(scene);
    const auto before = scene.snapshot();
    scene.merge_trees();
    const auto after = scene.snapshot();
    EXPECT_EQ(after->revision(), before->revision());
    expect_as_oracle(after, 7);
    if (after->shared_trees().static_tree() == old) continue;
    EXPECT_LT(round, 3 * kNodes / 4);
    ASSERT_EQ(sizes_of_dynamic(*after).size(), 1u);  // the newest
    const std::size_t newest = sizes_of_dynamic(*after).front();
    EXPECT_EQ(after->trees().static_tree().size(), kNodes - newest);
    EXPECT_EQ(after->trees().all().front().removed, nullptr);
    EXPECT_EQ(after->hierarchy().changed_at.size(), newest);
    ASSERT_TRUE(scene.apply({move(3, 1, 77)}));
    expect_as_oracle(scene.snapshot(), 8);
    return;
  }
  FAIL() << "the nodes have not come back";
}

TEST(Merge, IsDueOnceHalfOfTheSceneIsDeleted) {
  Scene scene;
  add_row(scene, 20);
  cast_one(scene);
  std::vector<model::Update> deleted;
  for (model::NodeRef id = 1; id <= 9; ++id) deleted.emplace_back(model::DeleteNode{id});
  auto applied = scene.apply(deleted);
  ASSERT_TRUE(applied);
  EXPECT_FALSE(applied->merge_trees);
  applied = scene.apply({model::DeleteNode{10}});
  ASSERT_TRUE(applied);
  EXPECT_TRUE(applied->merge_trees);
  cast_one(scene);
  scene.merge_trees();
  EXPECT_EQ(scene.snapshot()->trees().static_tree().size(), 10u);
  expect_as_oracle(scene.snapshot(), 9);
}

TEST(Merge, GrowsTheNewTreeWhereTheOldOnesWereGrown) {
  constexpr int kNodes = 3000;
  Scene scene;
  add_row(scene, kNodes);
  const std::vector<Ray> rays = rays_down_the_row(kNodes);
  TraceStats cold, merged;
  hits_in(*scene.snapshot(), rays, &cold);
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(scene.apply({move(1 + 1000 * round, 1000, round)}));
    hits_in(*scene.snapshot(), rays);
  }
  const auto applied = scene.apply({move(2500, 5, 2)});
  ASSERT_TRUE(applied);
  hits_in(*scene.snapshot(), rays);
  ASSERT_TRUE(applied->merge_trees);
  scene.merge_trees();
  hits_in(*scene.snapshot(), rays, &merged);
  // Not all of them: planes differ, and a cell may lie between the sampled positions.
  EXPECT_LT(10 * merged.touches, cold.touches);
}

TEST(Merge, OfTreesWithoutRaysDoesNothing) {
  Scene scene;
  add_row(scene, 10);
  const auto before = scene.snapshot();
  scene.merge_trees();
  EXPECT_EQ(scene.snapshot(), before);
}

/// A node moves after its tree was dropped, while the tree that replaces it is made.
TEST(Merge, MissesNoChangeWhileTreesAreDropped) {
  std::vector<Ray> here, there;
  for (int i = 0; i < 10; ++i) {
    here.push_back({{50.05 + 0.1 * i, 0.2, 9}, {0, 0, -1}});
    there.push_back({{-49.95 + 0.1 * i, 0.2, 9}, {0, 0, -1}});
  }
  for (int round = 0; round < 16; ++round) {
    Scene scene;
    add_row(scene, 3000);
    const std::vector<Hit> before = hits_in(*scene.snapshot(), here);
    ASSERT_EQ(before.front().node, 5u);
    std::vector<model::Update> deleted;
    for (model::NodeRef id = 1000; id < 2600; ++id) deleted.emplace_back(model::DeleteNode{id});
    const auto applied = scene.apply(deleted);
    ASSERT_TRUE(applied && applied->merge_trees);
    hits_in(*scene.snapshot(), here);
    std::atomic<bool> begun{false};
    std::thread merging([&] {
      begun = true;
      scene.merge_trees();
    });
    while (!begun) tests::sleep_shortly();
    for (int i = 0; i < 25 * round; ++i) std::this_thread::yield();
    if (round % 2 == 0) scene.drop_trees();
    ASSERT_TRUE(scene.apply({model::SetTransforms{{5}, {at(-50)}}}));
    merging.join();
    const std::vector<Hit> left = hits_in(*scene.snapshot(), here);
    const std::vector<Hit> moved = hits_in(*scene.snapshot(), there);
    for (std::size_t i = 0; i < here.size(); ++i) {
      ASSERT_NE(left[i].node, 5u) << "in round " << round;
      ASSERT_EQ(moved[i].node, before[i].node) << "in round " << round;
    }
  }
}

/// Revisions of one scene under a rule, some of them seen by rays, with merges between.
class RandomHistory {
 public:
  RandomHistory(const MergeRule& rule, tests::Frames frames, std::uint64_t seed)
      : random_(seed), frames_(frames), scene_(rule) {
    EXPECT_TRUE(scene_.apply(tests::random_hierarchy(150, frames, seed)));
  }

  void step() {
    std::vector<model::NodeRef> ids;
    scene_.snapshot()->nodes().for_each(
        [&](model::NodeId id, const std::shared_ptr<const model::Node>&) {
          ids.push_back(static_cast<model::NodeRef>(id));
        });
    const auto any = [&] { return ids[random_.below(ids.size())]; };
    std::vector<model::Update> updates;
    model::PutNode put = mesh_node(random_.below(2) == 0 ? -1 : any(), 0,
                                   static_cast<model::Mobility>(random_.below(3)),
                                   random_.below(4) == 0 ? 0 : any());
    put.parent_from_local = tests::random_frame(random_, frames_);
    updates.emplace_back(put);
    for (std::uint64_t i = random_.below(6); i > 0; --i)
      updates.emplace_back(model::SetTransforms{{any()}, {tests::random_frame(random_, frames_)}});
    if (ids.size() > 100) updates.emplace_back(model::DeleteNode{any(), random_.below(3) == 0});
    (void)scene_.apply(updates);
    if (random_.below(8) == 0) scene_.drop_trees();
    if (random_.below(3) > 0) cast_one(scene_);
    if (random_.below(2) == 0) scene_.merge_trees();
  }

  const Scene& scene() const { return scene_; }

 private:
  tests::Random random_;
  const tests::Frames frames_;
  Scene scene_;
};

/// All together: groups and instances of all mobilities change, some of them are seen by rays, and
/// trees are merged meanwhile.
TEST(Merge, KeepsHitsCorrectAmongAnyUpdates) {
  std::size_t most_trees = 0;
  std::uint64_t seed = 31;
  for (const std::uint64_t at_once : {0, 3, 8, 4096}) {
    for (const tests::Frames frames : {tests::Frames::kRigid, tests::Frames::kFar}) {
      RandomHistory history({.small_tree = at_once == 4096 ? 64u : 0u, .at_once = at_once}, frames,
                            ++seed);
      for (std::uint64_t round = 0; round < 60; ++round) {
        history.step();
        const auto snapshot = history.scene().snapshot();
        most_trees = std::max(most_trees, snapshot->shared_trees().levels.size());
        ASSERT_GE(snapshot->trees().size(), snapshot->hierarchy().summary(0).instances);
        if (round % 3 == 0) expect_as_oracle(snapshot, round);
        if (HasFailure()) return;
      }
    }
  }
  EXPECT_GT(most_trees, 5u);
}

}  // namespace
}  // namespace sightline::scenegraph::revision
