// Points in the tree of one mesh, built or not.
#include "accel/mesh/point_tests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "accel/mesh/mesh_stats.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/given_rays.h"
#include "accel/wide/transform.h"
#include "tests/support/hard_shapes.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/walk_in_doubles.h"

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

/// What points have expanded below a slot.
struct ExpandedCells {
  const wide::Frame& frame;
  const geometry::Vec3d& point;
  double answer;
  std::size_t all = 0, farther = 0;

  void add(kdtree::Slot slot) {
    for (std::size_t i = 0; slot.is_node() && i < kdtree::kWidth && slot.node()->child(i); ++i) {
      const kdtree::Slot child = slot.node()->child(i);
      if (child.is_deferred()) continue;
      ++all;
      // Boxes and limits are floats.
      if (distance_to(tests::box_of(*slot.node(), i, frame)) > answer * (1 + 0x1p-16)) ++farther;
      add(child);
    }
  }

 private:
  double distance_to(const geometry::Aabb& box) const {
    geometry::Vec3d gap;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gap[axis] = std::max({static_cast<double>(box.lo[axis]) - point[axis],
                            point[axis] - static_cast<double>(box.hi[axis]), 0.0});
    }
    return length(gap);
  }
};

/// This is the least that any order of expanding can build.
TEST(PointTests, ExpandNoCellThatIsFartherThanTheAnswer) {
  tests::Random random(3);
  for (const tests::TestMesh& mesh :
       {tests::icosphere(6), tests::hills(60'000, 2), tests::random_soup(20'000, 0.02, 4)}) {
    const MeshStats stats = compute_mesh_stats(mesh.view());
    const geometry::Vec3d lo(stats.bounds.lo), hi(stats.bounds.hi);
    std::size_t expanded = 0;
    for (int i = 0; i < 60; ++i) {
      MeshTree tree(mesh.view(), stats, TreeBuilder{});
      const double reach = i % 3 == 0 ? 0.6 : i % 3 == 1 ? 1 : 20;
      geometry::Vec3d at = (lo + hi) * 0.5;
      for (std::size_t axis = 0; axis < 3; ++axis)
        at[axis] += (hi[axis] - lo[axis]) * random.uniform(-reach, reach);
      OnePoint point(at);
      const kdtree::EpochPin pin;
      lazy::CellQuery cells;
      kdtree::WalkCounters walked;
      kdtree::BuildCounters built;
      tree.query(point.packet, 1, cells, walked, built);
      ASSERT_EQ(point.best.found, 1u);
      ExpandedCells below{tree.lazy_tree()->frame(), at, point.best.t[0]};
      below.add(kdtree::load(tree.lazy_tree()->root()));
      EXPECT_EQ(below.farther, 0u)
          << "of " << below.all << " from " << at.x << ", " << at.y << ", " << at.z;
      expanded += below.all;
    }
    EXPECT_GT(expanded, 60u);
  }
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
