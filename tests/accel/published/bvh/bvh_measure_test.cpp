// Metrics of hierarchies whose values can be computed by hand.
#include "accel/published/bvh/bvh_measure.h"

#include <gtest/gtest.h>

#include <vector>

#include "accel/geometry/clip.h"
#include "accel/published/bvh/bvh_growth.h"

namespace sightline::accel::published::bvh {
namespace {

kdtree::Reference ref(std::uint32_t id, const geometry::Aabb& box) {
  return {box.lo, id, box.hi, 1};
}

/// A root [0, 2] x [0, 1] x [0, 1] over leaves [0, 1.5] and [0.5, 2].
Bvh two_leaves() {
  BvhGrowth growth(3);
  const geometry::Aabb left{{0, 0, 0}, {1.5f, 1, 1}}, right{{0.5f, 0, 0}, {2, 1, 1}};
  const std::vector<kdtree::Reference> two{ref(0, left), ref(1, left)}, one{ref(2, right)};
  return growth.finish(growth.inner(growth.leaf(two, left), growth.leaf(one, right)));
}

TEST(BvhMeasure, SumsSharesOfTheRootsArea) {
  const kdtree::TreeMetrics m = measure(two_leaves());
  EXPECT_EQ(m.nodes, 3u);
  EXPECT_EQ(m.leaves, 2u);
  EXPECT_EQ(m.references, 3u);
  EXPECT_EQ(m.max_depth, 1);
  EXPECT_EQ(m.expected_traversals, 1);
  EXPECT_EQ(m.expected_leaves, 8.0 / 5);  // half areas: root 5, leaves 4
  EXPECT_DOUBLE_EQ(m.expected_intersections, (2 * 4 + 4) / 5.0);
  EXPECT_DOUBLE_EQ(m.sah_cost, 1 + 1.5 * 12 / 5);
  EXPECT_EQ(m.overlap, 3.0 / 5);  // [0.5, 1.5] x [0, 1] x [0, 1]
  EXPECT_EQ(m.bytes, sizeof(BvhNode) + 3 * sizeof(std::uint32_t));
}

TEST(BvhGrowth, ListsEachTriangleOnceALeafUnlessItRepeats) {
  BvhGrowth growth(3);
  const geometry::Aabb box{{0, 0, 0}, {1, 1, 1}};
  const std::vector<kdtree::Reference> thrice{ref(7, box), ref(3, box), ref(7, box)};
  const Bvh bvh = growth.finish(growth.leaf(thrice, box));
  EXPECT_EQ(bvh.ids, (std::vector<std::uint32_t>{7, 3}));
  BvhGrowth repeating(3, true);
  EXPECT_EQ(repeating.finish(repeating.leaf(thrice, box)).ids,
            (std::vector<std::uint32_t>{7, 3, 7}));
}

}  // namespace
}  // namespace sightline::accel::published::bvh
