// The hierarchy, opened on demand by rays: always in the same way, each instance once, in nested
// boxes.
#include "scenegraph/instances/instance_list.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <thread>

#include "accel/lazy/lazy_tree.h"
#include "scenegraph/instances/instance_bounds.h"
#include "scenegraph/instances/instance_group.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/all_instances.h"

namespace sightline::scenegraph::instances {
namespace {

/// All nodes in the static tree.
std::vector<model::Update> static_nodes(int nodes, tests::Frames frames, std::uint64_t seed) {
  std::vector<model::Update> updates = tests::random_hierarchy(nodes, frames, seed);
  for (model::Update& update : updates)
    std::get<model::PutNode>(update).mobility = model::Mobility::kStatic;
  return updates;
}

using accel::kdtree::Reference;
using tests::Frames;

constexpr Frames kAllFrames[] = {Frames::kRigid, Frames::kSheared, Frames::kFar, Frames::kFlat};

bool holds(const accel::geometry::Aabb& outer, const accel::geometry::Aabb& inner) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(outer.lo[a] <= inner.lo[a] && inner.hi[a] <= outer.hi[a])) return false;
  }
  return true;
}

/// All instances below these references.
void open_down(const Instances& instances, const std::vector<Reference>& refs,
               std::map<std::uint32_t, Reference>& found) {
  for (const Reference& ref : refs) {
    if (!ref.openable()) {
      EXPECT_TRUE(found.emplace(ref.id, ref).second) << "reached twice: " << ref.id;
      continue;
    }
    std::vector<Reference> finer;
    instances.open(ref, finer);
    EXPECT_FALSE(finer.empty());
    for (const Reference& part : finer) EXPECT_TRUE(holds(ref.bounds(), part.bounds())) << ref.id;
    open_down(instances, finer, found);
  }
}

std::map<std::uint32_t, Reference> open_down(const Instances& instances) {
  std::map<std::uint32_t, Reference> found;
  open_down(instances, instances.coarsest(), found);
  return found;
}

TEST(Instances, AreEachReachedOnceThroughBoxesThatContainThem) {
  for (const Frames frames : kAllFrames) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto snapshot = tests::snapshot_of(static_nodes(300, frames, seed));
      const Instances& instances = snapshot->trees().static_tree();
      const auto found = open_down(instances);
      ASSERT_EQ(found.size(), instances.size());
      ASSERT_EQ(found.size(), snapshot->hierarchy().summary(0).instances);
      for (const auto& [id, ref] : found) {
        const Instance& instance = instances[id];
        EXPECT_EQ(instance.index, id);
        EXPECT_EQ(instance.box, ref.bounds());
        EXPECT_TRUE(holds(instances.tree().tree().bounds(), instance.box));
      }
    }
  }
}

TEST(Instances, HaveTheTransformsOfTheHierarchy) {
  for (const Frames frames : kAllFrames) {
    const auto snapshot = tests::snapshot_of(static_nodes(400, frames, 3));
    model::NodeId before = 0;
    std::size_t count = 0;
    for (const Instance& instance : tests::all_instances(snapshot->trees().static_tree())) {
      const model::Node& node = *snapshot->find(instance.node);
      const model::Affine world = world_from_local(snapshot->hierarchy(), node);
      ASSERT_EQ(instance.local_from_world, *inverse(world));
      EXPECT_EQ(instance.mesh, node.mesh.get());
      EXPECT_EQ(instance.mask, node.mask);
      EXPECT_EQ(instance.entered, node.entered.get());
      // Clipping to the boxes of the groups above removes nothing.
      EXPECT_EQ(instance.box, instance_box(world, instance.local_from_world, node.mesh->bounds(),
                                           snapshot->trees().static_tree().center()));
      EXPECT_NE(instance.node, before);
      before = instance.node;
      ++count;
    }
    EXPECT_EQ(count, snapshot->trees().static_tree().size());
  }
}

TEST(Instances, BoxesContainTheirInstancesForAnyConditionNumber) {
  // Each transform alone is valid, and so is the whole: a node scales up again what its parent
  // scaled down.
  for (const double thickness : {1e-3, 1e-6, 1e-9}) {
    std::vector<model::Update> updates;
    tests::Random random(8);
    for (int i = 1; i <= model::kMaxDepth; ++i) {
      model::PutNode put;
      put.node = -i;
      put.parent = i == 1 ? 0 : -i + 1;
      const double scale = i % 2 == 0 ? thickness : 1 / thickness;
      put.parent_from_local =
          model::Affine{{1, 0, 0, random.uniform(-3, 3), 0, 1, 0, random.uniform(-3, 3), 0, 0,
                         scale, random.uniform(-3, 3)}};
      put.mesh = tests::some_mesh(static_cast<std::uint64_t>(i % 4));
      updates.emplace_back(put);
    }
    const auto snapshot = tests::snapshot_of(updates);
    EXPECT_EQ(open_down(snapshot->trees().static_tree()).size(),
              static_cast<std::size_t>(model::kMaxDepth));
  }
}

TEST(Instances, OpenTheSameWayInEveryOrderOnAnyThreads) {
  const auto updates = static_nodes(3000, Frames::kSheared, 6);
  const auto expected_of = tests::snapshot_of(updates);
  const auto expected = open_down(expected_of->trees().static_tree());
  for (int round = 0; round < 10; ++round) {
    const auto snapshot = tests::snapshot_of(updates);
    std::vector<std::map<std::uint32_t, Reference>> found(8);
    std::vector<std::thread> threads;
    for (auto& mine : found) {
      threads.emplace_back([&] { mine = open_down(snapshot->trees().static_tree()); });
    }
    for (std::thread& thread : threads) thread.join();
    for (const auto& mine : found) {
      ASSERT_EQ(mine.size(), expected.size());
      for (const auto& [id, ref] : expected) {
        ASSERT_EQ(mine.at(id).bounds(), ref.bounds());
        ASSERT_EQ(mine.at(id).weight, ref.weight);
        ASSERT_EQ(snapshot->trees().static_tree()[id].node,
                  expected_of->trees().static_tree()[id].node);
      }
    }
    EXPECT_EQ(snapshot->trees().static_tree().opened_members(),
              expected_of->trees().static_tree().opened_members());
  }
}

/// Groups of many kinds under one node, more than are placed at once: empty ones, with one
/// instance, with a few, with enough that runs are made, and with groups.
std::vector<model::Update> many_groups(int count) {
  std::vector<model::Update> updates;
  tests::Random random(9);
  model::NodeRef last = 0;
  const auto add = [&](model::NodeRef parent, double extent, bool mesh) {
    model::PutNode put;
    put.node = --last;
    put.parent = parent;
    put.parent_from_local.m[3] = random.uniform(0, extent);
    put.parent_from_local.m[7] = random.uniform(0, extent);
    if (mesh) put.mesh = tests::some_mesh(random.below(2));
    updates.emplace_back(put);
    return put.node;
  };
  const model::NodeRef root = add(0, 1, false);
  for (int i = 0; i < count; ++i) {
    const model::NodeRef group = add(root, 1e4, i % 5 == 0);
    const int children = i % 97 == 0 ? 200 : i % 4;
    for (int k = 0; k < children; ++k) {
      const model::NodeRef child = add(group, 50, k % 2 == 0);
      if (k % 8 == 0) add(child, 5, i % 3 > 0);
    }
  }
  return updates;
}

TEST(Instances, AreFoundByNumberAmongManyGroups) {
  const auto updates = many_groups(2500);
  const auto first = tests::snapshot_of(updates);
  const auto expected = open_down(first->trees().static_tree());
  ASSERT_EQ(expected.size(), first->trees().static_tree().size());
  // In another order: opens any group that is available.
  const auto snapshot = tests::snapshot_of(updates);
  const Instances& instances = snapshot->trees().static_tree();
  tests::Random random(10);
  std::map<std::uint32_t, Reference> found;
  std::vector<Reference> closed = instances.coarsest();
  while (!closed.empty()) {
    std::swap(closed[random.below(closed.size())], closed.back());
    const Reference ref = closed.back();
    closed.pop_back();
    if (ref.openable()) {
      instances.open(ref, closed);
    } else {
      EXPECT_TRUE(found.emplace(ref.id, ref).second);
    }
  }
  ASSERT_EQ(found.size(), expected.size());
  for (const auto& [id, ref] : expected) {
    ASSERT_EQ(found.at(id).bounds(), ref.bounds());
    ASSERT_EQ(instances[id].node, first->trees().static_tree()[id].node);
  }
}

TEST(Instances, WeighTheInstancesBelow) {
  const auto snapshot = tests::snapshot_of(static_nodes(2000, Frames::kRigid, 7));
  const Instances& instances = snapshot->trees().static_tree();
  const auto sum = [](const std::vector<Reference>& refs) {
    std::uint64_t weights = 0;
    for (const Reference& ref : refs) weights += ref.weight;
    return weights;
  };
  EXPECT_EQ(sum(instances.coarsest()), snapshot->hierarchy().summary(0).entry_cost);
  for (const Reference& ref : instances.coarsest()) {
    if (!ref.openable()) continue;
    std::vector<Reference> finer;
    instances.open(ref, finer);
    EXPECT_EQ(sum(finer), ref.weight);
  }
  EXPECT_EQ(weight_shift(std::uint64_t{1} << 31), 1u);
  EXPECT_EQ(weight_shift((std::uint64_t{1} << 31) - 1), 0u);
  EXPECT_EQ(weight_shift(std::uint64_t{1} << 40), 10u);
}

TEST(Instances, ThatAreFlatOrBelowFlatNodesAreNone) {
  const model::Affine flat{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}};
  // Alone it is good; twice, one above the other, it is not.
  const model::Affine thin{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e-8, 0}};
  const auto mesh = tests::some_mesh(0);
  const auto snapshot =
      tests::snapshot_of({tests::put_node(-1, 0, nullptr), tests::put_node(-2, -1, mesh, flat),
                          tests::put_node(-3, -1, mesh), tests::put_node(-4, -1, nullptr, flat),
                          tests::put_node(-5, -4, mesh), tests::put_node(-6, -1, nullptr, thin),
                          tests::put_node(-7, -6, mesh, thin)});
  const Instances& instances = snapshot->trees().static_tree();
  EXPECT_EQ(instances.size(), 2u) << "node 3, and 7, which is found out when its group is opened";
  EXPECT_EQ(snapshot->hierarchy().summary(0).mesh_nodes, 4u);
  const accel::geometry::Ray ray{{0.1, 0.2, 9}, {0, 0, -1}};
  accel::geometry::Hit hit;
  ASSERT_TRUE(trace(*snapshot, {&ray, 1}, {&hit, 1}, {}));
  EXPECT_EQ(hit.node, 3u);
  ASSERT_TRUE(build_all(*snapshot));
  for (const Instance& instance : tests::all_instances(instances))
    EXPECT_EQ(instance.mask != 0, instance.node == 3);
}

TEST(Instances, OfAnEmptyScene) {
  const Scene empty;
  EXPECT_EQ(empty.snapshot()->trees().static_tree().size(), 0u);
  EXPECT_TRUE(tests::all_instances(empty.snapshot()->trees().static_tree()).empty());
  std::vector<model::Update> groups;
  for (int i = 1; i <= 10; ++i) {
    model::PutNode put;
    put.node = -i;
    put.parent = -(i / 2);
    if (i > 5) put.mesh = tests::some_mesh(static_cast<std::uint64_t>(4 + i % 2));
    groups.emplace_back(put);
  }
  const auto snapshot = tests::snapshot_of(groups);
  EXPECT_EQ(snapshot->trees().static_tree().size(), 0u);
  EXPECT_TRUE(snapshot->trees().static_tree().coarsest().empty());
  EXPECT_EQ(snapshot->trees().static_tree().opened_members(), 0u);
}

/// Nodes in a chain above the only instance are opened at once.
TEST(Instances, OpenDownADeepChainFarAway) {
  std::vector<model::Update> updates;
  for (int i = 1; i <= model::kMaxDepth; ++i) {
    model::PutNode put;
    put.node = -i;
    put.parent = -i + 1;
    put.parent_from_local.m[3] = 1e5;
    if (i == model::kMaxDepth) put.mesh = tests::some_mesh(0);
    updates.emplace_back(put);
  }
  const auto snapshot = tests::snapshot_of(updates);
  ASSERT_EQ(snapshot->trees().static_tree().coarsest().size(), 1u);
  EXPECT_FALSE(snapshot->trees().static_tree().coarsest()[0].openable());
  const accel::geometry::Ray ray{{1e5 * model::kMaxDepth, 0.01, 9}, {0, 0, -1}};
  accel::geometry::Hit hit;
  ASSERT_TRUE(trace(*snapshot, {&ray, 1}, {&hit, 1}, {}));
  EXPECT_EQ(hit.node, static_cast<std::uint64_t>(model::kMaxDepth));
}

}  // namespace
}  // namespace sightline::scenegraph::instances
