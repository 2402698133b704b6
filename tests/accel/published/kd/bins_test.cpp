// Counting into bins, against counting directly.
#include "accel/published/kd/bins.h"

#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <set>

#include "tests/accel/boxes.h"

namespace sightline::accel::published::kd {
namespace {

TEST(AxisBins, CountsWhereBoxesStartAndEnd) {
  AxisBins bins(0, 8, 4);
  bins.add(0, 1, 1);
  bins.add(1.9f, 2, 10);  // A bound on a boundary belongs to the bin above it
  bins.add(-5, 99, 100);  // Bounds outside go to the first and the last bin
  bins.add(7, 8, 1000);
  const std::uint32_t starts[] = {111, 0, 0, 1000}, ends[] = {1, 10, 0, 1100};
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(bins.starts(i), starts[i]) << i;
    EXPECT_EQ(bins.ends(i), ends[i]) << i;
    EXPECT_EQ(bins.boundary(i), 2 * static_cast<float>(i));
  }
  EXPECT_EQ(bins.boundary(4), 8);
}

TEST(CountBins, EqualsDirectCounting) {
  const auto refs = tests::lattice_boxes(5000, 9, 1);  // Bounds at 0 to 5
  std::array<AxisBins, 3> axes{AxisBins(0, 8, 8), AxisBins(0, 8, 8), AxisBins(0, 8, 8)};
  count_bins(refs, Sampling{}, axes);
  for (std::size_t a = 0; a < 3; ++a) {
    AxisBins alone(0, 8, 8);
    count_bins(refs, a, alone);
    for (std::uint32_t i = 0; i < 8; ++i) {
      std::uint32_t starts = 0, ends = 0;
      for (const kdtree::Reference& ref : refs) {
        starts += static_cast<std::uint32_t>(ref.lo[a]) == i ? ref.weight : 0;
        ends += static_cast<std::uint32_t>(ref.hi[a]) == i ? ref.weight : 0;
      }
      EXPECT_EQ(axes[a].starts(i), starts);
      EXPECT_EQ(axes[a].ends(i), ends);
      EXPECT_EQ(alone.starts(i), starts);
      EXPECT_EQ(alone.ends(i), ends);
    }
  }
}

TEST(CountBins, DoesNotDependOnThreads) {
  const auto refs = tests::random_boxes(200000, 0.001, 2);
  std::array<std::array<AxisBins, 3>, 2> counted;
  std::array<geometry::Aabb, 2> bounds;
  for (std::size_t i = 0; i < 2; ++i) {
    tbb::task_arena arena(i == 0 ? 1 : 4);
    counted[i].fill(AxisBins(0, 1, 32));
    arena.execute([&] {
      count_bins(refs, Sampling{}, counted[i]);
      bounds[i] = content_bounds(refs, {{-1, -1, -1}, {2, 2, 2}});
    });
  }
  EXPECT_EQ(bounds[0], bounds[1]);
  EXPECT_EQ(bounds[0], bounds_of(refs));
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::uint32_t i = 0; i < 32; ++i) {
      EXPECT_EQ(counted[0][a].starts(i), counted[1][a].starts(i));
      EXPECT_EQ(counted[0][a].ends(i), counted[1][a].ends(i));
    }
  }
}

TEST(ContentBounds, EndAtTheCell) {
  const std::vector<kdtree::Reference> refs{tests::box_ref({0, 0, 0}, {4, 1, 1}),
                                            tests::box_ref({2, 0, 0}, {3, 2, 1})};
  EXPECT_EQ(content_bounds(refs, {{1, -1, 0}, {9, 1.5f, 9}}),
            (geometry::Aabb{{1, 0, 0}, {4, 1.5f, 1}}));
}

TEST(Sampling, TakesOneOfEveryStrideConsecutive) {
  for (const std::size_t stride : {1u, 2u, 5u}) {
    for (const std::size_t n : {1u, 4u, 5u, 1003u}) {
      const Sampling sampling{stride};
      EXPECT_EQ(sampling.size(n), (n + stride - 1) / stride);
      for (std::size_t k = 0; k < sampling.size(n); ++k) {
        EXPECT_LT(sampling.at(k, n), n);
        EXPECT_EQ(sampling.at(k, n) / stride, k);
      }
    }
  }
}

/// Every l-th reference is of another kind: a fixed stride would sample only one kind.
TEST(Sampling, IsNotBiasedByARegularOrder) {
  for (const std::size_t stride : {2u, 3u, 4u, 5u}) {
    const Sampling sampling{stride};
    const std::size_t n = 10000 * stride;
    std::vector<std::size_t> seen(stride);
    for (std::size_t k = 0; k < sampling.size(n); ++k) ++seen[sampling.at(k, n) % stride];
    for (const std::size_t count : seen)
      EXPECT_NEAR(static_cast<double>(count), 10000.0 / static_cast<double>(stride), 100);
  }
}

}  // namespace
}  // namespace sightline::accel::published::kd
