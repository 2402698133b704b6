// The exhaustive split against plain counting, on every SIMD target of this machine.
#include "accel/split/exhaustive_split.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/accel/boxes.h"
#include "tests/accel/simd_targets.h"

namespace sightline::accel::split {
namespace {

using BoundScan = tests::OnSimdTarget;

/// By the definition: every bound inside the cell, in order of axes; equal costs go to the least
/// position.
BoundSplit counted(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                   AxisRange range, float bonus, std::uint64_t& touches) {
  BoundSplit best;
  for (int axis = range.begin; axis < range.end; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const SplitAreas areas(cell, axis);
    const auto ends = static_cast<float>(areas.ends() * per_area(cell));
    const auto slope = static_cast<float>(areas.slope() * per_area(cell));
    std::size_t inside = 0;
    for (const kdtree::Reference& bound : refs) {
      for (const float x : {bound.lo[a], bound.hi[a]}) {
        if (!(x > cell.lo[a] && x < cell.hi[a])) continue;
        ++inside;
        std::uint32_t left = 0, right = 0;
        for (const kdtree::Reference& r : refs) {
          left += r.lo[a] < x ? r.weight : 0;
          right += r.hi[a] > x ? r.weight : 0;
        }
        float cost = (ends + slope * (x - cell.lo[a])) * static_cast<float>(left) +
                     (ends + slope * (cell.hi[a] - x)) * static_cast<float>(right);
        if (left == 0 || right == 0) cost *= bonus;
        const bool first =
            cost == best.children && axis == best.plane.axis && x < best.plane.position;
        if (cost < best.children || first) {
          best.children = cost;
          best.plane = {axis, x};
        }
      }
    }
    touches += (inside + kScanWidth - 1) / kScanWidth * refs.size();
  }
  return best;
}

void expect_same(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
  constexpr std::size_t kAll = 1000;
  for (const BoundRule& rule : {BoundRule{}, BoundRule{.cost = {}, .all_axes_up_to = 0},
                                BoundRule{.cost = {}, .all_axes_up_to = 9},
                                BoundRule{.cost = {}, .all_axes_up_to = 0, .retry_above = 0.7},
                                BoundRule{.cost = {1, 100, 1}, .all_axes_up_to = kAll}}) {
    const double weight = total_weight(refs);
    kdtree::BuildCounters expected, found;
    const BoundSplit best = best_bound(rule, cell, refs.size(), weight, [&](AxisRange range) {
      return counted(refs, cell, range, static_cast<float>(rule.cost.empty_bonus),
                     expected.touches);
    });
    const bool pays = best.found() && best.cost(rule.cost) < rule.cost.intersect * weight;
    const std::optional<kdtree::Split> cut = choose_bound(refs, cell, rule, found);
    ASSERT_EQ(found.touches, expected.touches) << refs.size();
    ASSERT_EQ(cut.has_value(), pays) << refs.size();
    if (cut) {
      ASSERT_EQ(cut->plane, best.plane) << refs.size();
    }
  }
}

TEST_P(BoundScan, FindsTheBestBound) {
  for (std::size_t n = 1; n <= kMaxBoundScan; n += n < 40 ? 1 : 27) {
    const auto refs = tests::random_boxes(n, 0.3, n);
    expect_same(refs, kdtree::bounds_of(refs));
    expect_same(refs, {{0.2f, 0.3f, 0.1f}, {0.8f, 0.7f, 0.9f}});  // Straddlers
  }
}

/// SplitAreas::children of a cut at a bound.
double scalar_cost(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                   const kdtree::Plane& plane, double bonus) {
  const auto a = static_cast<std::size_t>(plane.axis);
  double left = 0, right = 0;
  for (const kdtree::Reference& ref : refs) {
    left += ref.lo[a] < plane.position ? ref.weight : 0;
    right += ref.hi[a] > plane.position ? ref.weight : 0;
  }
  const SplitAreas areas(cell, plane.axis);
  return areas.children(static_cast<double>(plane.position), left, right, bonus);
}

TEST_P(BoundScan, ItsCutIsTheCheapestByTheScalarFormula) {
  constexpr double kFloats = 1e-5;  // the kernel's rounding
  const geometry::Aabb cell{{0.1f, 0.2f, 0.1f}, {0.9f, 0.8f, 0.95f}};
  for (std::size_t n = 2; n <= 64; n += 3) {
    const auto refs = tests::random_boxes(n, 0.1, n);
    kdtree::BuildCounters counters;
    const BoundRule rule{.cost = {0, 1, 0.85}};
    const auto cut = choose_bound(refs, cell, rule, counters);
    if (!cut) continue;
    const double chosen = scalar_cost(refs, cell, cut->plane, rule.cost.empty_bonus);
    for (const kdtree::Reference& ref : refs) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        for (const float x : {ref.lo[a], ref.hi[a]}) {
          if (!(x > cell.lo[a] && x < cell.hi[a])) continue;
          EXPECT_LE(chosen, (1 + kFloats) * scalar_cost(refs, cell, {axis, x}, 0.85)) << n;
        }
      }
    }
  }
}

TEST_P(BoundScan, EqualCostsGoToTheLeastAxisAndPosition) {
  for (std::size_t n = 1; n <= 40; ++n) {
    const auto refs = tests::lattice_boxes(n, 5, n);
    expect_same(refs, {{0, 0, 0}, {5, 5, 5}});
  }
}

TEST_P(BoundScan, FindsNothingIfNoBoundLiesInside) {
  const std::vector<kdtree::Reference> refs(9, tests::box_ref({0, 0, 0}, {1, 1, 1}));
  kdtree::BuildCounters counters;
  EXPECT_FALSE(choose_bound(refs, {{0, 0, 0}, {1, 1, 1}}, {.cost = {0, 1, 1}}, counters));
  EXPECT_EQ(counters.touches, 0u);
}

TEST_P(BoundScan, TriesTheOtherAxesIfTheLongestIsPoor) {
  // Two slabs across the shorter axis: no cut along x pays.
  const std::vector<kdtree::Reference> refs{tests::box_ref({0, 0, 0}, {4, 1, 1}),
                                            tests::box_ref({0, 2, 0}, {4, 3, 1})};
  const geometry::Aabb cell{{0, 0, 0}, {4, 3, 1}};
  kdtree::BuildCounters counters;
  EXPECT_FALSE(choose_bound(refs, cell, {.cost = {0, 1, 1}, .all_axes_up_to = 0}, counters));
  const auto cut = choose_bound(
      refs, cell, {.cost = {0, 1, 1}, .all_axes_up_to = 0, .retry_above = 0.85}, counters);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->plane, (kdtree::Plane{1, 1}));
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, BoundScan, tests::every_simd_target(),
                         tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::split
