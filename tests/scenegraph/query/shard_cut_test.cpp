// The cut of scenes into shards.
#include "scenegraph/query/shard_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "scenegraph/scene.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Ray;
using tests::Frames;
using tests::mesh_of;
using tests::put_node;

model::Affine at(double x) {
  model::Affine a;
  a.m[3] = x;
  return a;
}

/// Nodes 1 to `count`, with a cube each, along x in steps of `step`.
std::vector<model::Update> row_of_cubes(int count, double step) {
  const auto mesh = mesh_of(tests::cube());
  std::vector<model::Update> updates;
  for (int i = 1; i <= count; ++i) {
    auto put = put_node(-i, 0, mesh);
    put.parent_from_local = at(step * i);
    updates.emplace_back(put);
  }
  return updates;
}

std::vector<std::uint32_t> shards_of(const ShardCut& cut, model::NodeId count) {
  std::vector<std::uint32_t> shards;
  for (model::NodeId id = 1; id <= count; ++id) shards.push_back(cut.shard_of(id));
  return shards;
}

std::uint64_t instances_in(const ShardCut& cut) {
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < cut.size(); ++i) sum += cut[i].instances;
  return sum;
}

TEST(ShardCut, CutsARowIntoPartsOfEqualWeight) {
  const auto snapshot = tests::snapshot_of(row_of_cubes(6, 3));
  const ShardCut cut(*snapshot, 3);
  EXPECT_EQ(shards_of(cut, 6), (std::vector<std::uint32_t>{0, 0, 1, 1, 2, 2}));
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(cut[i].triangles, 24u);
}

TEST(ShardCut, LeavesShardsEmptyWhereThereAreFewerInstances) {
  const auto snapshot = tests::snapshot_of(row_of_cubes(2, 3));
  const ShardCut cut(*snapshot, kMaxShards);
  EXPECT_EQ(instances_in(cut), 2u);
  const ShardCut none(*tests::snapshot_of({put_node(-1, 0, nullptr)}), 4);
  EXPECT_EQ(instances_in(none), 0u);
}

TEST(ShardCut, HasEachInstanceOnceWhereAllCoincide) {
  const auto snapshot = tests::snapshot_of(row_of_cubes(9, 0));
  const ShardCut cut(*snapshot, 3);
  EXPECT_EQ(shards_of(cut, 9), (std::vector<std::uint32_t>{0, 0, 0, 1, 1, 1, 2, 2, 2})) << "by id";
}

TEST(ShardCut, BalancesTriangles) {
  for (const Frames frames : {Frames::kRigid, Frames::kSheared, Frames::kFar, Frames::kFlat}) {
    const auto snapshot = tests::snapshot_of(tests::random_hierarchy(300, frames, 7));
    std::uint64_t largest = 0, total = 0;
    snapshot->nodes().for_each([&](model::NodeId, const auto& node) {
      if (!hierarchy::is_instance(*node)) return;
      largest = std::max(largest, node->mesh->triangles());
      total += node->mesh->triangles();
    });
    const ShardCut cut(*snapshot, 3);
    for (std::uint32_t i = 0; i < 3; ++i) EXPECT_LE(cut[i].triangles, total / 3 + largest);
  }
}

/// Servers read the scene in other ways: from a snapshot, or by another series of updates.
TEST(ShardCut, IsAFunctionOfTheContent) {
  const auto updates = row_of_cubes(50, 2.5);
  Scene step_by_step;
  for (const model::Update& update : updates) ASSERT_TRUE(step_by_step.apply({update}));
  ASSERT_TRUE(step_by_step.apply({model::SetTransforms{{7}, {at(500)}}}));
  auto moved = updates;
  std::get<model::PutNode>(moved[6]).parent_from_local = at(500);
  const ShardCut a(*step_by_step.snapshot(), 5), b(*tests::snapshot_of(moved), 5);
  EXPECT_EQ(a.fingerprint(), b.fingerprint());
  EXPECT_EQ(shards_of(a, 50), shards_of(b, 50));
  EXPECT_NE(a.fingerprint(), ShardCut(*tests::snapshot_of(updates), 5).fingerprint());
  EXPECT_NE(a.fingerprint(), ShardCut(*step_by_step.snapshot(), 4).fingerprint());
}

TEST(ShardRay, OrdersShardsByEntryAndKnowsWhatIsTooFar) {
  const auto snapshot = tests::snapshot_of(row_of_cubes(6, 3));
  const ShardCut cut(*snapshot, 3);
  ShardRay ray(cut, /*points=*/false);
  ASSERT_TRUE(ray.begin({.origin = {100, 0, 0}, .direction = {-2, 0, 0}}));
  EXPECT_EQ(ray.by_entry(), (std::vector<std::uint8_t>{2, 1, 0}));
  EXPECT_TRUE(ray.may_meet(1, 43.5)) << "its box ends at x = 13";
  EXPECT_FALSE(ray.may_meet(1, 43.4));
  ASSERT_TRUE(ray.begin({.origin = {0, 5, 0}, .direction = {1, 0, 0}}));
  EXPECT_TRUE(ray.by_entry().empty());
  ASSERT_TRUE(ray.begin({.origin = {0, 0, 0}, .direction = {1, 0, 0}, .tmin = 8, .tmax = 11}));
  EXPECT_EQ(ray.by_entry(), (std::vector<std::uint8_t>{1}))
      << "the boxes end at x = 7 and begin at x = 14";
  EXPECT_FALSE(ray.begin({.origin = {0, 0, 0}, .direction = {0, 0, 0}}));
  EXPECT_FALSE(ray.may_meet(1, 100));
}

TEST(ShardRay, OrdersShardsByDistanceFromAPoint) {
  const auto snapshot = tests::snapshot_of(row_of_cubes(6, 3));
  const ShardCut cut(*snapshot, 3);
  ShardRay point(cut, /*points=*/true);
  ASSERT_TRUE(point.begin({.origin = {12.5, 4, 0}, .direction = {1, 0, 0}}));
  EXPECT_EQ(point.by_entry(), (std::vector<std::uint8_t>{1, 2, 0}))
      << "the boxes end and begin at x = 7, 8, 13 and 14";
  EXPECT_TRUE(point.may_meet(1, 3)) << "its box ends at y = 1";
  EXPECT_FALSE(point.may_meet(1, 2.9));
  ASSERT_TRUE(point.begin({.origin = {12.5, 4, 0}, .direction = {1, 0, 0}, .tmax = 3.5}));
  EXPECT_EQ(point.by_entry(), (std::vector<std::uint8_t>{1, 2}));
  ASSERT_TRUE(point.begin({.origin = {12.5, 0, 0}, .direction = {1, 0, 0}, .tmax = -1}));
  EXPECT_TRUE(point.by_entry().empty());
  EXPECT_FALSE(point.begin({.origin = {std::nan(""), 0, 0}, .direction = {1, 0, 0}}));
}

}  // namespace
}  // namespace sightline::scenegraph::query
