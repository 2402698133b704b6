// Two guided passes against the best of all bounds of a list.
#include "accel/split/guided_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "accel/published/any_builder.h"
#include "tests/accel/boxes.h"

namespace sightline::accel::split {
namespace {

/// By the definition, in units of weight; infinite for a plane that is not strictly inside.
double children(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                const kdtree::Plane& plane) {
  const auto a = static_cast<std::size_t>(plane.axis);
  if (!(plane.position > cell.lo[a] && plane.position < cell.hi[a]))
    return std::numeric_limits<double>::infinity();
  double left = 0, right = 0;
  for (const kdtree::Reference& r : refs) {
    left += r.lo[a] < plane.position ? r.weight : 0;
    right += r.hi[a] > plane.position ? r.weight : 0;
  }
  return split_cost({0, 1, 0.85}, SplitAreas(cell, plane.axis), static_cast<double>(plane.position),
                    left, right);
}

double best_children(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
  double best = std::numeric_limits<double>::infinity();
  for (const kdtree::Reference& r : refs) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      best = std::min(
          {best, children(refs, cell, {axis, r.lo[a]}), children(refs, cell, {axis, r.hi[a]})});
    }
  }
  return best;
}

double chosen(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
              GuidedRule rule = {}) {
  rule.cost = {0, 1, 0.85};
  kdtree::BuildCounters counters;
  const auto cut = choose_guided({refs, cell, {}}, rule, counters);
  EXPECT_LE(counters.touches, 2 * refs.size());
  return cut ? children(refs, cell, cut->plane) : total_weight(refs);
}

TEST(GuidedScan, IsNearTheBestBound) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const double size : {0.01, 0.1, 0.5}) {
      const auto refs = tests::random_boxes(500, size, seed);
      for (const geometry::Aabb& cell :
           {kdtree::bounds_of(refs), geometry::Aabb{{0, 0, 0}, {1, 1, 3}}}) {
        const double best = best_children(refs, cell);
        EXPECT_LT(chosen(refs, cell), 1.05 * best) << seed << " " << size;
        EXPECT_LT(chosen(refs, cell, {.cost = {}, .refine_all_axes = true}), 1.02 * best) << seed;
      }
    }
  }
}

/// Empty space is cut off exactly, wherever it ends.
TEST(GuidedScan, CutsAtAWall) {
  tests::Random random(1);
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 20; ++i) {
      const auto wall = static_cast<float>(random.uniform(0.05, 0.95));
      std::vector<kdtree::Reference> refs;
      for (int k = 0; k < 300; ++k) {
        geometry::Vec3f lo{static_cast<float>(random.uniform()),
                           static_cast<float>(random.uniform()),
                           static_cast<float>(random.uniform())};
        geometry::Vec3f hi = lo + geometry::Vec3f{0.01f, 0.01f, 0.01f};
        lo[static_cast<std::size_t>(axis)] = hi[static_cast<std::size_t>(axis)] = wall;
        refs.push_back(tests::box_ref(lo, hi));
      }
      geometry::Aabb cell{{0, 0, 0}, {1.01f, 1.01f, 1.01f}};
      EXPECT_LE(chosen(refs, cell), 1.0001 * best_children(refs, cell)) << axis << " " << wall;
    }
  }
}

/// A few heavy boxes beside many light ones: weights count, not numbers.
TEST(GuidedScan, CountsWeights) {
  auto refs = tests::random_boxes(400, 0.02, 1);
  for (kdtree::Reference& ref : refs) ref.weight = ref.lo.x < 0.2f ? 1000 : 1;
  const geometry::Aabb cell = kdtree::bounds_of(refs);
  EXPECT_LT(chosen(refs, cell), 1.02 * best_children(refs, cell));
}

TEST(GuidedScan, NeverCostsMoreThanItsEstimate) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto refs = tests::lattice_boxes(300, 50, seed);
    EXPECT_LE(chosen(refs, {{0, 0, 0}, {5, 5, 5}}), total_weight(refs)) << seed;
  }
}

TEST(GuidedScan, MakesALeafIfNothingSeparates) {
  const std::vector<kdtree::Reference> same(500, tests::box_ref({0, 0, 0}, {1, 1, 1}));
  kdtree::BuildCounters counters;
  EXPECT_FALSE(choose_guided({same, {{0, 0, 0}, {1, 1, 1}}, {}}, {}, counters));
  EXPECT_LE(counters.touches, 2 * same.size());
}

TEST(GuidedScan, HandlesAFlatCell) {
  std::vector<kdtree::Reference> refs;
  for (int i = 0; i < 100; ++i) {
    const auto x = static_cast<float>(i);
    refs.push_back(tests::box_ref({x, 0, 0}, {x + 1, 1, 0}));
  }
  kdtree::BuildCounters counters;
  const auto cut = choose_guided({refs, {{0, 0, 0}, {100, 1, 0}}, {}}, {}, counters);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->plane.axis, 0);
}

}  // namespace
}  // namespace sightline::accel::split
