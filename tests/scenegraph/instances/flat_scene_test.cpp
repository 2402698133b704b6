// One tree over the triangles of many instances: hits are those of the oracle, for every kind, also
// of rays that do not see all instances.
#include "scenegraph/instances/flat_scene.h"

#include <gtest/gtest.h>

#include <vector>

#include "accel/mesh/mesh_tree.h"
#include "scenegraph/query/build.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/expect_oracle.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/random.h"

namespace sightline::scenegraph::instances {
namespace {

using accel::geometry::Culling;
using tests::Frames;

bool is_flat(const Scene& scene) {
  return scene.snapshot()->trees().static_tree().flat() != nullptr;
}

void make_flat(const Scene& scene) {
  accel::kdtree::BuildCounters built;
  scene.snapshot()->trees().static_tree().make_flat(built);
}

class FlatScenes : public testing::TestWithParam<Frames> {};

TEST_P(FlatScenes, EqualTheOracleForEveryKind) {
  std::uint64_t hits = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Scene scene;
    ASSERT_TRUE(scene.apply(tests::random_hierarchy(200, GetParam(), seed)));
    make_flat(scene);
    ASSERT_TRUE(is_flat(scene));
    for (const Culling culling : {Culling::kNone, Culling::kBack, Culling::kFront})
      hits += tests::expect_oracle(scene, 300, seed, culling);
  }
  EXPECT_GT(hits, 1'000u);
}

TEST_P(FlatScenes, EqualTheOracleWhenNodesHaveMovedOrGone) {
  tests::Random random(7);
  std::uint64_t hits = 0;
  Scene scene;
  ASSERT_TRUE(scene.apply(tests::random_hierarchy(200, GetParam(), 5)));
  make_flat(scene);
  for (int round = 0; round < 6; ++round) {
    model::SetTransforms moves;
    for (int i = 0; i < 8; ++i) {
      moves.nodes.push_back(static_cast<model::NodeRef>(1 + random.below(200)));
      moves.parent_from_local.push_back(tests::random_frame(random, GetParam()));
    }
    ASSERT_TRUE(scene.apply({moves}));
    ASSERT_TRUE(is_flat(scene));
    hits += tests::expect_oracle(scene, 300, random.next());
  }
  EXPECT_GT(hits, 1'000u);
}

/// Instances of large meshes with several uses are entered; others are flat beside them.
TEST_P(FlatScenes, EqualTheOracleWhereSomeInstancesAreEntered) {
  tests::Random random(10);
  std::vector<model::Update> updates;
  const auto shared = tests::mesh_of(tests::icosphere(4));
  for (int i = 1; i <= 12; ++i) {
    const auto mesh = i % 2 == 0 ? shared : tests::mesh_of(tests::icosphere(2));
    updates.push_back(tests::put_node(-i, 0, mesh, tests::random_frame(random, GetParam())));
  }
  Scene scene;
  ASSERT_TRUE(scene.apply(updates));
  make_flat(scene);
  const auto flat = scene.snapshot()->trees().static_tree().flat();
  ASSERT_NE(flat, nullptr);
  EXPECT_GE(flat->boxes().size(), 6u);
  ASSERT_NE(flat->entered(), nullptr);
  for (const Culling culling : {Culling::kNone, Culling::kBack})
    EXPECT_GT(tests::expect_oracle(scene, 300, 12, culling), 50u);
}

/// A full build makes instances flat, and builds the trees of meshes that rays enter.
TEST(FlatScene, IsAllThatAFullBuildBuilds) {
  Scene scene;
  const auto shared = tests::mesh_of(tests::icosphere(4));
  const auto single = tests::mesh_of(tests::icosphere(2));
  ASSERT_TRUE(scene.apply({tests::put_node(-1, 0, shared, {}), tests::put_node(-2, 0, shared, {}),
                           tests::put_node(-3, 0, single, {})}));
  const auto snapshot = scene.snapshot();
  query::BuildProgress progress;
  ASSERT_TRUE(query::build_all(*snapshot, nullptr, &progress));
  EXPECT_TRUE(is_flat(scene));
  EXPECT_TRUE(snapshot->is_complete());
  EXPECT_EQ(progress.triangles_done, progress.triangles_total);
  EXPECT_EQ(progress.meshes_done, 2u);
  EXPECT_TRUE(shared->tree().is_complete());
  EXPECT_TRUE(single->tree().untouched());
  snapshot->trees().static_tree().drop_flat();
  EXPECT_FALSE(snapshot->is_complete());
}

TEST_P(FlatScenes, EqualTheOracleForRaysThatSeeAPart) {
  const auto updates = tests::random_hierarchy(200, GetParam(), 6);
  tests::Random random(8);
  Scene scene;
  ASSERT_TRUE(scene.apply(updates));
  make_flat(scene);
  const auto snapshot = scene.snapshot();
  std::vector<accel::geometry::Ray> rays = tests::rays_through(*snapshot, 400, 9);
  const auto selection =
      query::Selection::make(snapshot, 0, std::vector<model::NodeId>{1 + random.below(100)});
  ASSERT_TRUE(selection);
  TraceOptions options;
  options.selection = &*selection;
  std::vector<accel::geometry::Hit> flat(rays.size()), entered(rays.size());
  ASSERT_TRUE(trace(*snapshot, rays, flat, options));
  snapshot->trees().static_tree().drop_flat();
  ASSERT_FALSE(is_flat(scene));
  ASSERT_TRUE(trace(*snapshot, rays, entered, options));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(flat[i].t, entered[i].t) << i;
    ASSERT_EQ(flat[i].node, entered[i].node) << i;
    ASSERT_EQ(flat[i].primitive, entered[i].primitive) << i;
    ASSERT_EQ(flat[i].normal, entered[i].normal) << i;
  }
}

/// Rays make it once they have entered instances often enough, and many do so at once.
TEST(FlatScene, IsMadeByRaysThatHavePaid) {
  Scene scene;
  ASSERT_TRUE(scene.apply(tests::random_hierarchy(100, Frames::kRigid, 3)));
  const auto snapshot = scene.snapshot();
  const std::vector<accel::geometry::Ray> rays = tests::rays_through(*snapshot, 20'000, 4);
  std::vector<accel::geometry::Hit> first(rays.size()), later(rays.size());
  TraceOptions options;
  ASSERT_TRUE(trace(*snapshot, std::span(rays).first(10), std::span(first).first(10), options));
  EXPECT_FALSE(is_flat(scene));
  options.growth = Growth::kNone;
  const auto entering = trace(*snapshot, rays, first, options);
  ASSERT_TRUE(entering);
  EXPECT_FALSE(is_flat(scene));  // rays that grow nothing make no tree
  options.growth = Growth::kFirstTouch;
  for (int again = 0; again < 20 && !is_flat(scene); ++again)
    ASSERT_TRUE(trace(*snapshot, rays, later, options));
  EXPECT_TRUE(is_flat(scene));
  const auto traced = trace(*snapshot, rays, later, options);
  ASSERT_TRUE(traced);
  EXPECT_LT(traced->instances_entered, entering->instances_entered);  // dynamic ones are
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(first[i].t, later[i].t) << i;
    ASSERT_EQ(first[i].node, later[i].node) << i;
    ASSERT_EQ(first[i].primitive, later[i].primitive) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, FlatScenes,
                         testing::Values(Frames::kRigid, Frames::kSheared, Frames::kFar,
                                         Frames::kFlat));

}  // namespace
}  // namespace sightline::scenegraph::instances
