// Chains as deep as a hierarchy may be: boxes hold what is in them, rays find it.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "scenegraph/instances/instance_bounds.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/expect_oracle.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/all_instances.h"
#include "tests/support/kinds.h"
#include "tests/support/random.h"
#include "tests/support/rounds.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using tests::Random;

/// How a node of a chain lies in the one above it.
enum class Links {
  kTurned,   ///< By any rotation, a little farther.
  kScaled,   ///< Smaller and larger by turns, too.
  kSheared,  ///< Sheared and back by turns, between rotations.
  kOffset,   ///< Without rotation.
};

model::Affine link(Random& random, Links links, int depth) {
  if (links == Links::kOffset) return {{1, 0, 0, 0.25, 0, 1, 0, 0.5, 0, 0, 1, 1e-3}};
  model::Affine frame = random_frame(random, tests::Frames::kRigid, 0.3);
  if (links == Links::kScaled) {
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column)
        frame.m[4 * row + column] *= depth % 2 == 0 ? 0.8 : 1.25;
    }
  }
  if (links == Links::kSheared && depth % 2 == 0) {
    const model::Affine shear{{1, 0.01, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    frame = compose(compose(shear, frame), *inverse(shear));
  }
  return frame;
}

/// Every `step`th node of the chain has a mesh, and the last one.
std::vector<model::Update> chain(Links links, int depth, int step, model::Mobility mobility) {
  Random random(7);
  std::vector<model::Update> updates;
  for (int i = 1; i <= depth; ++i) {
    const auto mesh = i % step == 0 || i == depth ? tests::some_mesh(0) : nullptr;
    model::PutNode put = tests::put_node(-i, 1 - i, mesh, link(random, links, i));
    put.mobility = mobility;
    updates.emplace_back(put);
  }
  return updates;
}

constexpr std::size_t kChainRays = tests::rounds(60);

class DeepChains : public testing::TestWithParam<Links> {};

TEST_P(DeepChains, EqualTheOracleStaticAndMoving) {
  for (const model::Mobility mobility : {model::Mobility::kStatic, model::Mobility::kRigid}) {
    for (const int step : {1, 37, model::kMaxDepth}) {
      Scene scene;
      const auto applied = scene.apply(chain(GetParam(), model::kMaxDepth, step, mobility));
      ASSERT_TRUE(applied) << applied.error().message;
      EXPECT_EQ(scene.snapshot()->hierarchy().summary(0).height, model::kMaxDepth + 1u);
      std::uint64_t hits = tests::expect_oracle(scene, kChainRays, 1);
      Random random(8);
      for (int round = 0; round < 2; ++round) {
        model::SetTransforms moves;
        for (int i = 0; i < 3; ++i) {
          const int at = 1 + static_cast<int>(random.below(model::kMaxDepth));
          moves.nodes.push_back(at);
          moves.parent_from_local.push_back(link(random, Links::kTurned, at));
        }
        ASSERT_TRUE(scene.apply({moves}));
        hits += tests::expect_oracle(scene, kChainRays, random.next());
      }
      EXPECT_GT(hits, kChainRays);
    }
  }
}

/// Boxes of boxes grow by every rotation, and bounds of errors with them, unless lengths limit
/// them.
TEST_P(DeepChains, HaveBoxesThatHoldTheirInstancesAndAreOfTheirSize) {
  Scene scene;
  ASSERT_TRUE(scene.apply(chain(GetParam(), model::kMaxDepth, 1, model::Mobility::kStatic)));
  const auto snapshot = scene.snapshot();
  const revision::WorldBounds& bounds = snapshot->bounds();
  const hierarchy::NodeSummary all = snapshot->hierarchy().summary(0);
  double length = 0;
  snapshot->nodes().for_each([&](model::NodeId, const auto& node) {
    const auto& m = node->parent_from_local.m;
    length += std::hypot(m[3], m[7], m[11]);
  });
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_LE(all.box.lo[a], bounds.lo[a]);
    EXPECT_GE(all.box.hi[a], bounds.hi[a]);
    if (GetParam() != Links::kSheared) {
      EXPECT_LT(std::fabs(all.box.lo[a]), 8 * length);
      EXPECT_LT(std::fabs(all.box.hi[a]), 8 * length);
    }
  }
  const instances::Instances& tree = snapshot->trees().static_tree();
  std::size_t count = 0;
  for (const instances::Instance& instance : tests::all_instances(tree)) {
    const model::Node& node = *snapshot->find(instance.node);
    // The boxes of the groups above take nothing off.
    ASSERT_EQ(instance.box, instances::instance_box(world_from_local(snapshot->hierarchy(), node),
                                                    instance.local_from_world, node.mesh->bounds(),
                                                    tree.center()));
    ++count;
  }
  EXPECT_EQ(count, static_cast<std::size_t>(model::kMaxDepth));
}

INSTANTIATE_TEST_SUITE_P(All, DeepChains,
                         testing::Values(Links::kTurned, Links::kScaled, Links::kSheared,
                                         Links::kOffset));

TEST(DeepChain, AreManyInOneBatch) {
  Scene scene;
  std::vector<model::Update> updates;
  constexpr int kChains = 200;
  for (int k = 0; k < kChains; ++k) {
    std::vector<model::Update> one =
        chain(Links::kOffset, model::kMaxDepth, model::kMaxDepth, model::Mobility::kStatic);
    for (int i = 0; i < model::kMaxDepth; ++i) {
      auto& put = std::get<model::PutNode>(one[static_cast<std::size_t>(i)]);
      put.node -= k * model::kMaxDepth;
      if (i > 0) put.parent -= k * model::kMaxDepth;
    }
    updates.insert(updates.end(), one.begin(), one.end());
  }
  ASSERT_TRUE(scene.apply(updates));
  EXPECT_EQ(scene.snapshot()->hierarchy().summary(0).instances, static_cast<unsigned>(kChains));
  EXPECT_EQ(scene.snapshot()->trees().size(), static_cast<unsigned>(kChains));
}

}  // namespace
}  // namespace sightline::scenegraph
