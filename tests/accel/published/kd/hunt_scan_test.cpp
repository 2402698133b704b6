// Hunt's choice of a plane.
#include "accel/published/kd/hunt_scan.h"

#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <cmath>
#include <vector>

#include "accel/published/any_builder.h"
#include "tests/accel/boxes.h"
#include "tests/accel/published/kd/cuts.h"
#include "tests/support/random.h"

namespace sightline::accel::published::kd {
namespace {

using tests::box_ref;
using tests::counted_cost;
using tests::random_boxes;

double best_possible(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                     const split::SahConstants& constants) {
  double best = 1e300;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    for (const kdtree::Reference& r : refs) {
      for (const float x : {r.lo[a], r.hi[a]}) {
        if (x > cell.lo[a] && x < cell.hi[a])
          best = std::min(best, counted_cost(refs, cell, {axis, x}, constants));
      }
    }
  }
  return best;
}

TEST(HuntScan, FindsTheOptimumWhenExact) {
  const HuntScan builder;
  for (std::size_t n = 1; n <= builder.exact_below; ++n) {
    const std::vector<kdtree::Reference> refs = random_boxes(n, 0.1, n);
    const geometry::Aabb cell = bounds_of(refs);
    kdtree::BuildCounters counters;
    const auto plane = builder.choose({refs, cell, 0}, counters);
    const double best = best_possible(refs, cell, builder.cost);
    if (best < static_cast<double>(n)) {
      ASSERT_TRUE(plane) << n;
      EXPECT_NEAR(counted_cost(refs, cell, plane->plane, builder.cost), best,
                  1e-6 * best)  // Costs are computed in float
          << n;
    } else {
      EXPECT_FALSE(plane) << n;
    }
  }
}

TEST(HuntScan, SampledChoiceIsNearTheOptimumOnSmoothInput) {
  for (const ScanAxes axes : {ScanAxes::kAll, ScanAxes::kHybrid}) {
    HuntScan builder;
    builder.axes = axes;
    const std::vector<kdtree::Reference> refs = random_boxes(1000, 0.02, 5);
    const geometry::Aabb cell = bounds_of(refs);
    kdtree::BuildCounters counters;
    const auto plane = builder.choose({refs, cell, 0}, counters);
    ASSERT_TRUE(plane);
    EXPECT_LT(counted_cost(refs, cell, plane->plane, builder.cost),
              1.03 * best_possible(refs, cell, builder.cost));
    EXPECT_EQ(counters.touches,
              2 * refs.size());  // The uniform and the adaptive pass, all axes fused
  }
}

/// A wall of many flat boxes: the adaptive samples concentrate on it (section 5.1).
TEST(HuntScan, AdaptiveSamplesConcentrateOnAStep) {
  std::vector<kdtree::Reference> refs = random_boxes(200, 0.01, 6);
  for (int i = 0; i < 2000; ++i) {
    const auto y = static_cast<float>(i % 50) / 50, z = static_cast<float>(i / 50) / 40;
    refs.push_back(box_ref({0.637f, y, z}, {0.637f, y + 0.02f, z + 0.025f}));
  }
  geometry::Aabb cell = bounds_of(refs);
  cell.hi.x = 1.5f;  // The longest axis
  HuntScan builder;
  builder.axes = ScanAxes::kOne;
  kdtree::BuildCounters counters;
  const auto plane = builder.choose({refs, cell, 0}, counters);
  ASSERT_TRUE(plane);
  // Nearly all of the rise lies in the wall's segment, so it gets at least all teeth but one.
  const double segment = (static_cast<double>(cell.hi.x) - static_cast<double>(cell.lo.x)) /
                         (builder.uniform_samples - 1);
  EXPECT_LT(std::fabs(static_cast<double>(plane->plane.position) - 0.637),
            segment / builder.adaptive_samples);
}

TEST(HuntScan, OneAxisCutsTheLongest) {
  HuntScan builder;
  builder.axes = ScanAxes::kOne;
  std::vector<kdtree::Reference> refs = random_boxes(500, 0.01, 7);
  for (kdtree::Reference& r : refs) {
    r.lo.z *= 10;
    r.hi.z *= 10;
  }
  kdtree::BuildCounters counters;
  EXPECT_EQ(builder.choose({refs, bounds_of(refs), 0}, counters)->plane.axis, 2);
}

TEST(HuntScan, HeavyReferencesPullThePlane) {
  // Two light boxes left, one heavy box right: the cut separates the heavy one.
  std::vector<kdtree::Reference> refs{box_ref({0, 0, 0}, {1, 1, 1}), box_ref({1, 0, 0}, {2, 1, 1}),
                                      box_ref({8, 0, 0}, {9, 1, 1}, 2, 1000)};
  const geometry::Aabb cell = bounds_of(refs);
  kdtree::BuildCounters counters;
  const auto plane = HuntScan{}.choose({refs, cell, 0}, counters);
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->plane, (kdtree::Plane{0, 8}));
}

TEST(HuntScan, MakesALeafIfNothingSeparates) {
  const HuntScan builder;
  kdtree::BuildCounters counters;
  EXPECT_FALSE(builder.choose({{}, {{0, 0, 0}, {1, 1, 1}}, 0}, counters));
  for (const std::size_t n : {1u, 20u, 500u}) {
    const std::vector<kdtree::Reference> same(n, box_ref({0, 0, 0}, {1, 1, 1}));
    EXPECT_FALSE(builder.choose({same, bounds_of(same), 0}, counters)) << n;
  }
}

TEST(HuntScan, ParallelScansChooseTheSamePlane) {
  const std::vector<kdtree::Reference> refs = random_boxes(200000, 0.001, 9);
  const geometry::Aabb cell = bounds_of(refs);
  std::vector<kdtree::Split> cuts;
  for (const int threads : {1, 2, 4}) {
    tbb::task_arena arena(threads);
    kdtree::BuildCounters counters;
    cuts.push_back(*arena.execute([&] { return HuntScan{}.choose({refs, cell, 0}, counters); }));
  }
  EXPECT_EQ(cuts[0], cuts[1]);
  EXPECT_EQ(cuts[0], cuts[2]);
}

TEST(HuntScan, CheckNamesTheParameterAndItsRange) {
  HuntScan builder;
  EXPECT_FALSE(builder.check());
  builder.uniform_samples = 16;
  EXPECT_FALSE(builder.check());
  builder.uniform_samples = 17;
  EXPECT_EQ(*builder.check(), "uniform_samples is 17, must lie in 2 to 16");
}

TEST(AnyBuilder, IsMadeAndSetByName) {
  for (const std::string_view name : builder_names()) EXPECT_TRUE(make_builder(name)) << name;
  const auto unknown = make_builder("octree");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("scan-all-axes"), std::string::npos);
  AnyBuilder builder = *make_builder("scan-hybrid");
  EXPECT_TRUE(set_parameter(builder, "samples", "4"));
  const auto& scan = std::get<HuntScan>(std::get<KdBuilder>(builder));
  EXPECT_EQ(scan.adaptive_samples, 4u);
  EXPECT_FALSE(set_parameter(builder, "samples", "40"));
  EXPECT_FALSE(set_parameter(builder, "samples", "-1"));
  EXPECT_FALSE(set_parameter(builder, "samples", "many"));
  EXPECT_FALSE(set_parameter(builder, "colour", "1"));
  EXPECT_EQ(scan.adaptive_samples, 4u);
}

}  // namespace
}  // namespace sightline::accel::published::kd
