// Hierarchies under rays: each is built once, by the first ray, and walks visit no box in vain.
#include "accel/published/bvh/bvh_tree.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include <tbb/parallel_for.h>

#include "accel/published/bvh/traverse.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::accel::published::bvh {
namespace {

TEST(BvhTree, IsBuiltOnceByManyThreads) {
  const tests::TestMesh mesh = tests::icosphere(5);
  BvhTree tree(mesh.view(), BvhBuilder{.method = BvhMethod::kSpatial});
  EXPECT_EQ(tree.built(), nullptr);
  EXPECT_EQ(tree.bytes(), 0u);
  std::vector<kdtree::BuildCounters> counters(4);
  std::vector<std::thread> threads;
  for (kdtree::BuildCounters& own : counters) threads.emplace_back([&] { tree.build(own); });
  for (std::thread& thread : threads) thread.join();
  std::uint64_t built = 0;
  for (const kdtree::BuildCounters& own : counters) built += own.cells_expanded;
  EXPECT_EQ(built, 1u);
  ASSERT_NE(tree.built(), nullptr);
  EXPECT_EQ(tree.bytes(), tree.built()->bytes());
}

// A building thread must not run another ray's task, which would wait for the same build.
TEST(BvhTree, IsBuiltFromWithinTasks) {
  const tests::TestMesh mesh = tests::random_soup(50'000, 0.02, 8);
  BvhTree tree(mesh.view(), BvhBuilder{});
  std::atomic<int> done = 0;
  tbb::parallel_for(0, 64, [&](int) {
    kdtree::BuildCounters counters;
    tree.build(counters);
    ++done;
  });
  EXPECT_EQ(done, 64);
}

/// Box tests only: meet_children against the slab test of a single box.
TEST(BvhWalk, MeetChildrenAgreesWithTheSingleBoxTest) {
  tests::Random random(6);
  int met = 0;
  for (int i = 0; i < 20'000; ++i) {
    BvhNode node;
    std::array<geometry::Aabb, 2> boxes;
    for (const std::size_t side : {0u, 1u}) {
      for (std::size_t a = 0; a < 3; ++a) {
        const auto x = static_cast<float>(random.uniform(-1, 1));
        boxes[side].lo[a] = x;
        boxes[side].hi[a] = x + static_cast<float>(random.uniform(0, 0.5));
      }
      node.set(side, {.box = boxes[side]});
      EXPECT_EQ(node.child(side).box, boxes[side]);
    }
    geometry::Vec3d origin{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
    geometry::Vec3d direction = geometry::Vec3d(boxes[0].lo) - origin;
    if (i % 3 == 0) direction[static_cast<std::size_t>(i / 3) % 3] = i % 2 == 0 ? 0.0 : -0.0;
    if (i % 5 == 0) origin.x = static_cast<double>(boxes[0].lo.x);
    const geometry::LocalRay local = *geometry::make_local_ray(origin, direction);
    kdtree::TreeRay ray;
    if (!enter(local, {{-1, -1, -1}, {1.5f, 1.5f, 1.5f}}, 0, 10, ray)) continue;
    const BvhMeeting meeting = meet_children(node, ray, ray.t_out);
    for (const std::size_t side : {0u, 1u}) {
      if (may_meet(ray, boxes[side], ray.t_out)) {
        EXPECT_TRUE(meeting.meets[side]);
        ++met;
      }
    }
  }
  EXPECT_GT(met, 1000);
}

}  // namespace
}  // namespace sightline::accel::published::bvh
