// Points in the tree of one mesh, built or not.
#include "accel/mesh/point_tests.h"

#include <gtest/gtest.h>

#include <atomic>

#include "accel/mesh/mesh_stats.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/given_rays.h"
#include "accel/wide/transform.h"
#include "tests/support/scenes.h"

namespace sightline::accel::mesh {
namespace {

constexpr wide::Matrix kUnmoved{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// A packet with one point, in the frame of a mesh that is not moved.
struct OnePoint {
  wide::GivenRays given;
  wide::BestHits best;
  wide::Packet packet;

  explicit OnePoint(const geometry::Vec3d& at) {
    const geometry::Ray ray{.origin = at, .direction = {1, 0, 0}};
    wide::read(std::span(&ray, 1), given);
    best.clear();
    packet.best = &best;
    packet.points = &given;
    packet.scene_from_local = packet.local_from_scene = &kUnmoved;
    wide::transform(given, kUnmoved, 1, packet.rays);
  }
};

struct SphereTree {
  tests::TestMesh mesh = tests::icosphere(5);
  MeshTree tree{mesh.view(), compute_mesh_stats(mesh.view()), TreeBuilder{}};
  kdtree::WalkCounters walked;
  kdtree::BuildCounters built;

  void ask(OnePoint& point, lazy::Growth growth) {
    const kdtree::EpochPin pin;
    lazy::CellQuery cells;
    cells.growth = growth;
    walked = {};
    tree.query(point.packet, 1, cells, walked, built);
  }
};

TEST(PointTests, SearchAMeshThatIsNotBuilt) {
  SphereTree sphere;
  for (const lazy::Growth growth : {lazy::Growth::kNone, lazy::Growth::kFirstTouch}) {
    OnePoint point({0, 0, 3});
    sphere.ask(point, growth);
    ASSERT_EQ(point.best.found, 1u);
    EXPECT_EQ(point.best.t[0], 2);
  }
  EXPECT_EQ(sphere.walked.tests < sphere.mesh.faces.size() / 4, true);
}

/// A point in the middle visits all of a sphere, unless it is cancelled.
TEST(PointTests, StopInTheMiddleOfASphereWhenCancelled) {
  SphereTree sphere;
  sphere.tree.expand_all(sphere.built);
  OnePoint whole({0, 0, 0});
  sphere.ask(whole, lazy::Growth::kNone);
  EXPECT_EQ(whole.best.found, 1u);
  EXPECT_FALSE(whole.packet.stopped);
  const std::uint64_t all = sphere.walked.tests;
  EXPECT_GT(all, sphere.mesh.faces.size() / 2);

  const std::atomic<bool> cancelled{true};
  OnePoint stopped({0, 0, 0});
  stopped.packet.cancelled = &cancelled;
  sphere.ask(stopped, lazy::Growth::kNone);
  EXPECT_TRUE(stopped.packet.stopped);
  EXPECT_LT(sphere.walked.tests, all / 4);
}

}  // namespace
}  // namespace sightline::accel::mesh
