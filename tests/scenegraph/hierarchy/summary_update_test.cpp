// After any updates, the summaries equal newly computed ones.
#include "scenegraph/hierarchy/summary_update.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/scenegraph/random_hierarchy.h"

namespace sightline::scenegraph::hierarchy {
namespace {

using tests::Frames;
using tests::Random;

/// Computed as if all nodes had just been put.
Hierarchy added_up(const Hierarchy& hierarchy) {
  Hierarchy again = hierarchy;
  again.summaries = {};
  again.summary_trees = {};
  const Hierarchy nothing;
  SummaryUpdate update(nothing, again);
  again.nodes.for_each(
      [&](model::NodeId id, const std::shared_ptr<const model::Node>&) { update.edited(id); });
  update.finish();
  return again;
}

void expect_up_to_date(const Hierarchy& hierarchy) {
  const Hierarchy expected = added_up(hierarchy);
  ASSERT_EQ(hierarchy.summaries.size(), expected.summaries.size());
  expected.summaries.for_each(
      [&](model::NodeId id, const std::shared_ptr<const NodeSummary>& summary) {
        const std::shared_ptr<const NodeSummary>* kept = hierarchy.summaries.find(id);
        ASSERT_NE(kept, nullptr) << id;
        ASSERT_EQ(**kept, *summary) << id;
      });
}

std::vector<model::NodeId> ids_of(const revision::Snapshot& snapshot) {
  std::vector<model::NodeId> ids;
  snapshot.nodes().for_each(
      [&](model::NodeId id, const std::shared_ptr<const model::Node>&) { ids.push_back(id); });
  return ids;
}

/// Any update; a refused one must change nothing.
model::Update random_update(Random& random, const std::vector<model::NodeId>& ids, Frames frames,
                            int alias) {
  const auto any = [&] { return static_cast<model::NodeRef>(ids[random.below(ids.size())]); };
  switch (random.below(5)) {
    case 0:
      return model::DeleteNode{any(), random.below(4) == 0};
    case 1:
    case 2: {
      const model::NodeRef one = any(), other = any();
      if (one == other) return model::SetTransforms{{one}, {random_frame(random, frames)}};
      return model::SetTransforms{{one, other},
                                  {random_frame(random, frames), random_frame(random, frames)}};
    }
    default: {
      model::PutNode put;
      put.node = random.below(2) == 0 ? alias : any();
      put.parent = random.below(6) == 0 ? 0 : any();
      put.parent_from_local = random_frame(random, frames);
      if (random.below(3) > 0) put.mesh = tests::some_mesh(random.next());
      return put;
    }
  }
}

class SubtreesInFrames : public testing::TestWithParam<Frames> {};

TEST_P(SubtreesInFrames, StayCorrectThroughAnyUpdates) {
  const Frames frames = GetParam();
  Random random(17);
  Scene scene;
  ASSERT_TRUE(scene.apply(tests::random_hierarchy(120, frames, 4)));
  expect_up_to_date(scene.snapshot()->hierarchy());
  int applied = 0;
  for (int round = 0; round < 400; ++round) {
    const std::vector<model::NodeId> ids = ids_of(*scene.snapshot());
    if (ids.size() < 20) {
      ASSERT_TRUE(scene.apply(tests::random_hierarchy(60, frames, random.next())));
    }
    std::vector<model::Update> updates;
    const auto count = static_cast<int>(1 + random.below(4));
    for (int i = 1; i <= count; ++i) updates.push_back(random_update(random, ids, frames, -i));
    applied += scene.apply(updates) ? 1 : 0;
    expect_up_to_date(scene.snapshot()->hierarchy());
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(applied, 100);
}

INSTANTIATE_TEST_SUITE_P(All, SubtreesInFrames,
                         testing::Values(Frames::kRigid, Frames::kSheared, Frames::kFar,
                                         Frames::kFlat));

TEST(Subtrees, FollowOneOfManyChildrenAtATime) {
  Random random(5);
  Scene scene;
  std::vector<model::Update> updates;
  model::PutNode top;
  top.node = -1;
  updates.emplace_back(top);
  for (int i = 2; i <= 300; ++i) {
    model::PutNode put;
    put.node = -i;
    put.parent = -1;
    put.parent_from_local = random_frame(random, Frames::kRigid);
    put.mesh = tests::some_mesh(random.next());
    updates.emplace_back(put);
  }
  ASSERT_TRUE(scene.apply(updates));
  for (int round = 0; round < 300; ++round) {
    // Inward and outward, with and without a child that alone determines an extreme.
    const auto id = static_cast<model::NodeRef>(2 + random.below(299));
    ASSERT_TRUE(scene.apply({model::SetTransforms{
        {id}, {random_frame(random, Frames::kRigid, round % 3 == 0 ? 40 : 3)}}}));
    expect_up_to_date(scene.snapshot()->hierarchy());
    if (HasFatalFailure()) return;
  }
}

TEST(Subtrees, FollowManyChildrenOnLevelGround) {
  Scene scene;
  model::PutNode ground;
  ground.node = -1;
  std::vector<model::Update> updates{ground};
  for (int i = 2; i <= 100; ++i) {
    model::PutNode put;
    put.node = -i;
    put.parent = -1;
    put.mesh = tests::some_mesh(2);
    put.parent_from_local.m[3] = i % 10;
    put.parent_from_local.m[7] = static_cast<double>(i / 10);
    updates.emplace_back(put);
  }
  ASSERT_TRUE(scene.apply(updates));
  EXPECT_EQ(scene.snapshot()->hierarchy().group(1).extreme_counts[6], 99u) << "down";
  for (model::NodeRef id = 2; id <= 100; ++id) {
    model::Affine up;
    up.m[11] = static_cast<double>(id % 3);
    ASSERT_TRUE(scene.apply({model::SetTransforms{{id}, {up}}}));
    expect_up_to_date(scene.snapshot()->hierarchy());
  }
}

/// Groups grow beyond SummaryTree::kWide and shrink below it again.
TEST(Subtrees, FollowHundredsOfAddedAndDeletedChildren) {
  Random random(21);
  Scene scene;
  model::PutNode one, other;
  one.node = -1;
  other.node = -2;
  ASSERT_TRUE(scene.apply({one, other}));
  std::vector<model::NodeRef> alive;
  for (int round = 0; round < 60; ++round) {
    std::vector<model::Update> updates;
    const bool grows = round % 20 < 10;
    for (int i = 1; grows && i <= 400; ++i) {
      model::PutNode put;
      put.node = -i;
      put.parent = static_cast<model::NodeRef>(random.below(3));
      put.parent_from_local = random_frame(random, Frames::kRigid, 10);
      put.mesh = tests::some_mesh(random.next());
      updates.emplace_back(put);
    }
    for (std::size_t i = 0; !grows && i < 400 && !alive.empty(); ++i) {
      std::swap(alive[random.below(alive.size())], alive.back());
      updates.emplace_back(model::DeleteNode{alive.back()});
      alive.pop_back();
    }
    for (std::size_t i = 0; i < 5 && !alive.empty(); ++i) {
      updates.emplace_back(model::SetTransforms{{alive[random.below(alive.size())]},
                                                {random_frame(random, Frames::kRigid, 40)}});
    }
    const auto applied = scene.apply(updates);
    ASSERT_TRUE(applied) << applied.error().message;
    alive.insert(alive.end(), applied->nodes.begin(), applied->nodes.end());
    expect_up_to_date(scene.snapshot()->hierarchy());
    if (HasFatalFailure()) return;
  }
}

TEST(Subtrees, CountNodesAndTriangles) {
  const auto snapshot = tests::snapshot_of(tests::random_hierarchy(500, Frames::kRigid, 9));
  NodeSummary expected;
  snapshot->nodes().for_each([&](model::NodeId, const std::shared_ptr<const model::Node>& node) {
    if (node->mesh == nullptr) return;
    ++expected.mesh_nodes;
    expected.triangles += node->mesh->triangles();
    if (node->mesh->triangles() == node->mesh->nonfinite()) return;
    ++expected.instances;
    expected.entry_cost += entry_cost(*node->mesh);
  });
  const NodeSummary all = snapshot->hierarchy().summary(0);
  EXPECT_EQ(all.mesh_nodes, expected.mesh_nodes);
  EXPECT_EQ(all.triangles, expected.triangles);
  EXPECT_EQ(all.instances, expected.instances);
  EXPECT_EQ(all.entry_cost, expected.entry_cost);
  EXPECT_GT(all.mesh_nodes, all.instances);
}

TEST(Subtrees, ContainEveryVertexInTheirFrame) {
  for (const Frames frames : {Frames::kRigid, Frames::kSheared, Frames::kFar, Frames::kFlat}) {
    const auto snapshot = tests::snapshot_of(tests::random_hierarchy(200, frames, 11));
    snapshot->nodes().for_each(
        [&](model::NodeId id, const std::shared_ptr<const model::Node>& node) {
          if (node->mesh == nullptr || node->mesh->bounds().empty()) return;
          // Upward, one frame after the other, in double.
          for (const accel::geometry::Vec3f& v : node->mesh->view().vertices) {
            long double p[] = {static_cast<long double>(v.x), static_cast<long double>(v.y),
                               static_cast<long double>(v.z)};
            for (const model::Node* at = node.get();;) {
              const NodeSummary summary = snapshot->hierarchy().summary(*at);
              for (std::size_t a = 0; a < 3; ++a) {
                ASSERT_GE(p[a], static_cast<long double>(summary.box.lo[a])) << id;
                ASSERT_LE(p[a], static_cast<long double>(summary.box.hi[a])) << id;
              }
              if (at->parent == 0) break;
              const auto& m = at->parent_from_local.m;
              const long double q[] = {p[0], p[1], p[2]};
              for (std::size_t row = 0; row < 3; ++row) {
                p[row] = static_cast<long double>(m[4 * row + 3]);
                for (std::size_t col = 0; col < 3; ++col)
                  p[row] += static_cast<long double>(m[4 * row + col]) * q[col];
              }
              at = snapshot->find(at->parent);
            }
          }
        });
  }
}

TEST(Subtrees, OfAnEmptiedSceneAreDropped) {
  Scene scene;
  ASSERT_TRUE(scene.apply(tests::random_hierarchy(50, Frames::kRigid, 2)));
  while (!scene.snapshot()->roots().empty()) {
    const auto root = static_cast<model::NodeRef>(scene.snapshot()->roots().front());
    ASSERT_TRUE(scene.apply({model::DeleteNode{root, true}}));
    expect_up_to_date(scene.snapshot()->hierarchy());
  }
  EXPECT_EQ(scene.snapshot()->hierarchy().summary(0), NodeSummary{});
}

}  // namespace
}  // namespace sightline::scenegraph::hierarchy
