// Nodes that are mirrored keep their outside, at rest and moving, for every kind of query.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/expect_oracle.h"
#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"
#include "tests/support/kinds.h"
#include "tests/support/random.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Culling;
using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using tests::Frames;
using tests::Random;

/// In either orientation, about equally often.
model::Affine any_orientation(Random& random, double reach) {
  model::Affine frame = random_frame(random, Frames::kRigid, reach);
  if (random.below(2) == 0) {
    const std::size_t column = random.below(3);
    for (std::size_t row = 0; row < 3; ++row) frame.m[4 * row + column] *= -random.uniform(0.5, 2);
  }
  return frame;
}

/// Closed meshes below groups below groups, all in either orientation.
std::vector<model::Update> nested_mirrors(Random& random, model::Mobility mobility, double scale) {
  std::vector<model::Update> updates;
  const auto meshes = {tests::mesh_of(tests::icosphere(2)), tests::mesh_of(tests::cube())};
  int alias = 0;
  const auto add = [&](model::NodeRef parent, const std::shared_ptr<const model::Mesh>& mesh,
                       const model::Affine& frame) {
    model::PutNode put = tests::put_node(--alias, parent, mesh, frame);
    put.mobility = mobility;
    updates.emplace_back(put);
    return put.node;
  };
  const model::NodeRef all = add(0, nullptr, {{scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0}});
  for (int outer = 0; outer < 4; ++outer) {
    const model::NodeRef group = add(all, nullptr, any_orientation(random, 3));
    for (int inner = 0; inner < 3; ++inner) {
      const model::NodeRef within = add(group, nullptr, any_orientation(random, 2));
      for (const auto& mesh : meshes) add(within, mesh, any_orientation(random, 2));
    }
  }
  return updates;
}

/// Every culling, and normals. Returns the number of hits that were compared.
std::uint64_t expect_sides(const Scene& scene, std::uint64_t seed) {
  std::uint64_t hits = 0;
  for (const Culling culling : {Culling::kNone, Culling::kBack, Culling::kFront})
    hits += tests::expect_oracle(scene, 300, seed, culling);
  const auto snapshot = scene.snapshot();
  const std::vector<Ray> rays = tests::rays_through(*snapshot, 300, seed);
  std::vector<Hit> closest(rays.size());
  EXPECT_TRUE(trace(*snapshot, rays, closest, {}));
  const auto surfaces =
      tests::compare(rays, closest, tests::BruteForce(snapshot), {.surface = true});
  EXPECT_TRUE(surfaces.clean()) << surfaces.report();
  return hits;
}

/// In the last scene coordinates are too large for leaf blocks.
TEST(MirroredNodes, EqualTheOracleForEveryKindAndCulling) {
  Random random(3);
  std::uint64_t hits = 0;
  for (const double scale : {1.0, 0x1p+62}) {
    for (const model::Mobility mobility : {model::Mobility::kStatic, model::Mobility::kRigid}) {
      for (int round = 0; round < 4; ++round) {
        Scene scene;
        ASSERT_TRUE(scene.apply(nested_mirrors(random, mobility, scale)));
        hits += expect_sides(scene, random.next());
      }
    }
  }
  EXPECT_GT(hits, 4'000u);
}

TEST(MirroredNodes, EqualTheOracleWhileTheyMoveAndTurnIntoTheirMirrors) {
  Random random(4);
  Scene scene;
  ASSERT_TRUE(scene.apply(nested_mirrors(random, model::Mobility::kStatic, 1)));
  std::uint64_t hits = expect_sides(scene, 1);  // opens the static tree
  for (int round = 0; round < 12; ++round) {
    model::SetTransforms moves;
    for (int i = 0; i < 5; ++i) {
      moves.nodes.push_back(static_cast<model::NodeRef>(2 + random.below(40)));
      moves.parent_from_local.push_back(any_orientation(random, 3));
    }
    ASSERT_TRUE(scene.apply({moves}));
    if (round % 3 == 0) scene.merge_trees();
    hits += expect_sides(scene, random.next());
  }
  EXPECT_GT(hits, 3'000u);
}

/// Rays that leave a closed mesh meet backs, rays that come to it fronts, whatever mirrors it.
TEST(MirroredNodes, HaveTheirNormalsOutside) {
  Random random(5);
  for (int round = 0; round < 100; ++round) {
    Scene scene;
    std::vector<model::Update> chain;
    model::Affine world;
    for (int depth = 1; depth <= 3; ++depth) {
      const model::Affine frame = any_orientation(random, 2);
      world = depth == 1 ? frame : compose(world, frame);
      chain.emplace_back(tests::put_node(
          -depth, 1 - depth, depth == 3 ? tests::mesh_of(tests::cube()) : nullptr, frame));
    }
    ASSERT_TRUE(scene.apply(chain));
    const Vec3d inside = world.point({0.1, 0.2, 0.3});
    const Vec3d direction = random.direction() * 50.0;
    const Ray rays[] = {{inside, direction}, {inside + direction, direction * -1.0}};
    TraceOptions no_backs, no_fronts;
    no_backs.culling = Culling::kBack;
    no_fronts.culling = Culling::kFront;
    Hit out, in, seen[2];
    ASSERT_TRUE(trace(*scene.snapshot(), {&rays[0], 1}, {&out, 1}, {}));
    ASSERT_TRUE(trace(*scene.snapshot(), {&rays[1], 1}, {&in, 1}, {}));
    EXPECT_GT(dot(Vec3d(out.normal), rays[0].direction), 0);
    EXPECT_LT(dot(Vec3d(in.normal), rays[1].direction), 0);
    ASSERT_TRUE(trace(*scene.snapshot(), rays, seen, no_backs));
    EXPECT_NE(seen[0].state, accel::geometry::HitState::kHit);
    EXPECT_EQ(seen[1].t, in.t);
    ASSERT_TRUE(trace(*scene.snapshot(), rays, seen, no_fronts));
    EXPECT_EQ(seen[0].t, out.t);
    EXPECT_GT(seen[1].t, in.t);
  }
}

}  // namespace
}  // namespace sightline::scenegraph
