// Median cuts.
#include "accel/published/kd/median_builders.h"

#include <gtest/gtest.h>

#include "tests/accel/boxes.h"

namespace sightline::accel::published::kd {
namespace {

using tests::box_ref;

TEST(SpatialMedian, CyclesThroughTheAxesAndCutsTheMiddle) {
  const auto refs = tests::random_boxes(100, 0.01, 1);
  const geometry::Aabb cell{{0, 0, 0}, {1, 2, 4}};
  kdtree::BuildCounters counters;
  for (const int depth : {0, 1, 2, 3, 7}) {
    const auto cut = SpatialMedianBuilder{}.choose({refs, cell, {depth}}, counters);
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->plane.axis, depth % 3);
    EXPECT_EQ(cut->plane.position, depth % 3 == 0 ? 0.5f : depth % 3 == 1 ? 1.0f : 2.0f);
  }
  EXPECT_EQ(counters.touches, 5 * refs.size());
}

TEST(SpatialMedian, SkipsAnAxisThatSeparatesNothing) {
  std::vector<kdtree::Reference> refs;  // Rods along x
  for (int i = 0; i < 20; ++i) {
    const auto y = static_cast<float>(i);
    refs.push_back(box_ref({0, y, 0}, {9, y + 0.5f, 1}));
  }
  kdtree::BuildCounters counters;
  const auto cut = SpatialMedianBuilder{}.choose({refs, bounds_of(refs), {0}}, counters);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->plane.axis, 1);
  const std::vector<kdtree::Reference> same(20, refs[0]);
  EXPECT_FALSE(SpatialMedianBuilder{}.choose({same, bounds_of(same), {0}}, counters));
}

TEST(ObjectMedian, HalvesTheObjectsOfTheLongestAxis) {
  std::vector<kdtree::Reference> refs;
  for (int i = 0; i < 101; ++i) {
    const auto x = static_cast<float>(i * i);  // Denser at the lower end
    refs.push_back(box_ref({0, x, 0}, {1, x + 1, 1}));
  }
  kdtree::BuildCounters counters;
  const auto cut = ObjectMedianBuilder{}.choose({refs, bounds_of(refs), {}}, counters);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->plane, (kdtree::Plane{1, 50 * 50 + 0.5f}));
}

TEST(ObjectMedian, RefusesCutsThatLeaveEverythingOnOneSide) {
  std::vector<kdtree::Reference> refs;  // Rods along y, the longest axis, side by side in z
  for (int i = 0; i < 20; ++i) {
    const auto z = static_cast<float>(i);
    refs.push_back(box_ref({0, 0, z}, {1, 50, z + 0.5f}));
  }
  kdtree::BuildCounters counters;
  const auto cut = ObjectMedianBuilder{}.choose({refs, bounds_of(refs), {}}, counters);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->plane.axis, 2);
  const std::vector<kdtree::Reference> same(20, refs[0]);
  EXPECT_FALSE(ObjectMedianBuilder{}.choose({same, bounds_of(same), {}}, counters));
}

TEST(Medians, StopAtTheLeafSize) {
  const auto refs = tests::random_boxes(9, 0.01, 2);
  const std::span<const kdtree::Reference> eight = std::span(refs).first(8);
  kdtree::BuildCounters counters;
  EXPECT_TRUE(SpatialMedianBuilder{}.choose({refs, bounds_of(refs), {}}, counters));
  EXPECT_TRUE(ObjectMedianBuilder{}.choose({refs, bounds_of(refs), {}}, counters));
  EXPECT_FALSE(SpatialMedianBuilder{}.choose({eight, bounds_of(refs), {}}, counters));
  EXPECT_FALSE(ObjectMedianBuilder{}.choose({eight, bounds_of(refs), {}}, counters));
  EXPECT_TRUE(SpatialMedianBuilder{.stop = {.leaf_size = 2}}.choose({eight, bounds_of(refs), {}},
                                                                    counters));
}

TEST(Medians, BoundTheDepth) {
  EXPECT_EQ(SpatialMedianBuilder{}.depth_bound(1 << 20), 34);  // 8 + 1.3 * 20
  EXPECT_EQ(SpatialMedianBuilder{}.depth_bound(0), 8);
  EXPECT_EQ((ObjectMedianBuilder{.stop = {.max_depth = 5}}.depth_bound(1 << 20)), 5);
}

TEST(Medians, CheckNamesTheParameterAndItsRange) {
  EXPECT_FALSE(SpatialMedianBuilder{}.check());
  EXPECT_EQ(*(SpatialMedianBuilder{.stop = {.leaf_size = 0}}.check()),
            "leaf_size is 0, must lie in 1 to 1000000");
  EXPECT_EQ(*(ObjectMedianBuilder{.stop = {.max_depth = 81}}.check()),
            "max_depth is 81, must lie in 0 to 80");
}

}  // namespace
}  // namespace sightline::accel::published::kd
