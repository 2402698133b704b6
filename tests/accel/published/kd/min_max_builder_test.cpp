// The choice among bin boundaries.
#include "accel/published/kd/min_max_builder.h"

#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include "tests/accel/boxes.h"
#include "tests/accel/published/kd/cuts.h"

namespace sightline::accel::published::kd {
namespace {

using tests::box_ref;
using tests::counted_cost;

double best_bound(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                  const split::SahConstants& constants) {
  double best = 1e300;
  for (const int axis : {0, 1, 2}) {
    const auto a = static_cast<std::size_t>(axis);
    for (const kdtree::Reference& ref : refs) {
      for (const float x : {ref.lo[a], ref.hi[a]}) {
        if (x > cell.lo[a] && x < cell.hi[a])
          best = std::min(best, counted_cost(refs, cell, {axis, x}, constants));
      }
    }
  }
  return best;
}

std::optional<kdtree::Split> choose(const MinMaxBuilder& builder,
                                    const std::vector<kdtree::Reference>& refs,
                                    const geometry::Aabb& cell, int depth = 0) {
  kdtree::BuildCounters counters;
  return builder.choose({refs, cell, {depth}}, counters);
}

TEST(MinMaxBuilder, IsExactForAsManyBoxesAsBins) {
  const MinMaxBuilder builder;
  for (std::size_t n = 1; n <= 32; ++n) {
    const auto refs = tests::random_boxes(n, 0.1, n);
    const geometry::Aabb cell = bounds_of(refs);
    const auto cut = choose(builder, refs, cell);
    const double best = best_bound(refs, cell, builder.cost);
    if (best < builder.cost.intersect * static_cast<double>(n)) {
      ASSERT_TRUE(cut) << n;
      EXPECT_NEAR(counted_cost(refs, cell, cut->plane, builder.cost), best, 1e-6 * best) << n;
    } else {
      EXPECT_FALSE(cut) << n;
    }
  }
}

TEST(MinMaxBuilder, BinsApproximateTheOptimum) {
  for (const bool subsample : {false, true}) {
    const MinMaxBuilder builder{.subsample = subsample, .threads = 1};
    for (const std::size_t n : {200u, 2000u}) {
      const auto refs = tests::random_boxes(n, 0.02, n);
      const geometry::Aabb cell = bounds_of(refs);
      const auto cut = choose(builder, refs, cell);
      ASSERT_TRUE(cut);
      EXPECT_LT(counted_cost(refs, cell, cut->plane, builder.cost),
                1.05 * best_bound(refs, cell, builder.cost));
    }
  }
}

TEST(MinMaxBuilder, CutsOffEmptySpaceWhereTheContentsEnd) {
  const auto refs = tests::random_boxes(1000, 0.01, 3);
  const geometry::Aabb contents = bounds_of(refs);
  geometry::Aabb cell = contents;
  cell.hi.y = 20;
  const auto cut = choose({.threads = 1}, refs, cell);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->plane, (kdtree::Plane{1, contents.hi.y}));
}

/// F10 of the failure catalogue: objects and floor alternate in the list. The objects are at one
/// end, the floor is everywhere.
TEST(MinMaxBuilder, SamplesSeeEverySecondReference) {
  std::vector<kdtree::Reference> refs;
  for (int i = 0; i < 600; ++i) {
    const auto s = static_cast<float>(i) / 600;
    refs.push_back(box_ref({s, 0, s}, {s + 0.01f, 0.01f, s + 0.01f}));  // The floor
    refs.push_back(box_ref({0.1f * s, 0.5f, 0.1f}, {0.1f * s + 0.001f, 0.6f, 0.2f}, 0));  // Objects
  }
  const geometry::Aabb cell = bounds_of(refs);
  const MinMaxBuilder sampled{.threads = 1}, all{.subsample = false, .threads = 1};
  const auto cut = choose(sampled, refs, cell);
  ASSERT_TRUE(cut);
  EXPECT_LT(counted_cost(refs, cell, cut->plane, all.cost),
            1.1 * counted_cost(refs, cell, choose(all, refs, cell)->plane, all.cost));
}

TEST(MinMaxBuilder, DecomposesAtTheMedian) {
  auto refs = tests::random_boxes(20000, 0.001, 4);
  for (std::size_t i = 0; i < refs.size(); ++i) {
    refs[i].lo.x = refs[i].lo.x * refs[i].lo.x * 8;  // Denser at the lower end of the longest axis
    refs[i].hi.x = refs[i].lo.x + 0.001f;
  }
  const geometry::Aabb cell = bounds_of(refs);
  const MinMaxBuilder builder{.threads = 4};
  for (const int depth : {0, 1}) {
    const auto cut = choose(builder, refs, cell, depth);
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->plane.axis, 0);
    double left = 0, right = 0;
    for (const kdtree::Reference& ref : refs) {
      left += ref.lo.x < cut->plane.position ? 1 : 0;
      right += ref.hi.x > cut->plane.position ? 1 : 0;
    }
    EXPECT_NEAR(left, right, 0.01 * 20000) << depth;
  }
  EXPECT_EQ(choose(builder, refs, cell, 2), choose({.threads = 1}, refs, cell));  // One thread left
}

TEST(MinMaxBuilder, ThreadsChooseTheSamePlane) {
  const auto refs = tests::random_boxes(300000, 0.001, 5);
  const geometry::Aabb cell = bounds_of(refs);
  for (const std::uint32_t threads : {1u, 8u}) {
    std::vector<std::optional<kdtree::Split>> cuts;
    for (const int arena_threads : {1, 4}) {
      tbb::task_arena arena(arena_threads);
      cuts.push_back(arena.execute([&] { return choose({.threads = threads}, refs, cell); }));
    }
    EXPECT_EQ(cuts[0], cuts[1]);
  }
}

TEST(MinMaxBuilder, MakesALeafIfNothingSeparates) {
  EXPECT_FALSE(choose({}, {}, {{0, 0, 0}, {1, 1, 1}}));
  for (const std::size_t n : {1u, 20u, 500u, 20000u}) {
    const std::vector<kdtree::Reference> same(n, box_ref({0, 0, 0}, {1, 1, 1}));
    EXPECT_FALSE(choose({.threads = 4}, same, bounds_of(same))) << n;
  }
}

TEST(MinMaxBuilder, CheckNamesTheParameterAndItsRange) {
  EXPECT_FALSE(MinMaxBuilder{}.check());
  EXPECT_EQ(*MinMaxBuilder{.bins = 1}.check(), "bins is 1, must lie in 2 to 256");
  EXPECT_TRUE(MinMaxBuilder{.threads = 5000}.check());
}

}  // namespace
}  // namespace sightline::accel::published::kd
