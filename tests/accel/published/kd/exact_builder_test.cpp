// The exact heuristic: one optimum, found in three ways.
#include "accel/published/kd/exact_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "accel/kdtree/sift.h"
#include "tests/accel/boxes.h"
#include "tests/accel/published/kd/cuts.h"

namespace sightline::accel::published::kd {
namespace {

using tests::box_ref;

double true_cost(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                 const kdtree::Split& cut, const ExactCosts& costs) {
  double left = 0, right = 0;
  std::vector<kdtree::Reference> l(refs.size()), r(refs.size());
  const kdtree::PartitionCounts n = kdtree::sift(refs, cut, l.data(), r.data());
  for (std::size_t i = 0; i < n.left; ++i) left += l[i].weight;
  for (std::size_t i = 0; i < n.right; ++i) right += r[i].weight;
  const geometry::HalvedCell halves = halve(cell, cut.plane.axis, cut.plane.position);
  const double children =
      (half_area(halves.left) * left + half_area(halves.right) * right) / half_area(cell);
  const double cost = costs.traverse + costs.intersect * children;
  return left == 0 || right == 0 ? cost * costs.lambda : cost;
}

/// Every bound, both sides, without cuts that change nothing.
double best_possible(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
                     const ExactCosts& costs) {
  double best = 1e300;
  for (const int axis : {0, 1, 2}) {
    const auto a = static_cast<std::size_t>(axis);
    for (const kdtree::Reference& ref : refs) {
      for (const float x : {ref.lo[a], ref.hi[a]}) {
        for (const bool planar_left : {false, true}) {
          const kdtree::Split cut{.plane = {axis, x}, .planar_left = planar_left};
          std::vector<kdtree::Reference> l(refs.size()), r(refs.size());
          const kdtree::PartitionCounts n = kdtree::sift(refs, cut, l.data(), r.data());
          if (x <= cell.lo[a] || x >= cell.hi[a]) continue;
          if (n.left == refs.size() && n.right == refs.size()) continue;
          if (x == geometry::least_above(ref.lo[a]))
            continue;  // Behind a flat box: not a bound of any box
          best = std::min(best, true_cost(refs, cell, cut, costs));
        }
      }
    }
  }
  return best;
}

double weight_of(const std::vector<kdtree::Reference>& refs) {
  double sum = 0;
  for (const kdtree::Reference& ref : refs) sum += ref.weight;
  return sum;
}

void check_optimum(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
  std::vector<std::optional<kdtree::Split>> cuts;
  for (const ExactSearch search : tests::kExactSearches) {
    const ExactBuilder builder{.search = search};
    kdtree::BuildCounters counters;
    cuts.push_back(builder.choose({refs, cell, {}}, counters));
    const double best = best_possible(refs, cell, builder.costs);
    const double leaf = builder.costs.intersect * weight_of(refs);
    if (cuts.back()) {
      EXPECT_LE(true_cost(refs, cell, *cuts.back(), builder.costs), best * (1 + 1e-12));
      EXPECT_LE(true_cost(refs, cell, *cuts.back(), builder.costs), leaf * (1 + 1e-12));
    } else {
      EXPECT_GE(best, leaf * (1 - 1e-12));
    }
  }
  EXPECT_EQ(cuts[0], cuts[1]);
  EXPECT_EQ(cuts[0], cuts[2]);
}

TEST(ExactBuilder, FindsTheOptimum) {
  for (std::size_t n = 1; n <= 60; ++n) {
    const auto loose = tests::random_boxes(n, 0.3, n);
    check_optimum(loose, bounds_of(loose));
    check_optimum(loose, {{0.2f, 0.1f, 0.3f}, {0.7f, 0.9f, 0.6f}});  // Boxes reach beyond the cell
    const auto lattice = tests::lattice_boxes(n, 3, n);
    check_optimum(lattice, bounds_of(lattice));
    check_optimum(lattice, {{-1, -1, -1}, {7, 7, 7}});  // Empty space on all sides
  }
}

TEST(ExactBuilder, HeavyReferencesPullThePlane) {
  const std::vector<kdtree::Reference> refs{box_ref({0, 0, 0}, {1, 1, 1}),
                                            box_ref({1, 0, 0}, {2, 1, 1}),
                                            box_ref({8, 0, 0}, {9, 1, 1}, 2, 1000)};
  for (const ExactSearch search : tests::kExactSearches) {
    kdtree::BuildCounters counters;
    const auto cut = ExactBuilder{.search = search}.choose({refs, bounds_of(refs), {}}, counters);
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->plane, (kdtree::Plane{0, 8}));
  }
}

TEST(ExactBuilder, MakesALeafIfNothingSeparates) {
  for (const ExactSearch search : tests::kExactSearches) {
    const ExactBuilder builder{.search = search, .bad_refines = 9};
    kdtree::BuildCounters counters;
    EXPECT_FALSE(builder.choose({{}, {{0, 0, 0}, {1, 1, 1}}, {}}, counters));
    const std::vector<kdtree::Reference> same(50, box_ref({0, 0, 0}, {1, 1, 1}));
    EXPECT_FALSE(builder.choose({same, bounds_of(same), {}}, counters));
    const std::vector<kdtree::Reference> flat(50, box_ref({0, 0, 2}, {1, 1, 2}));
    EXPECT_FALSE(builder.choose({flat, bounds_of(flat), {}}, counters));
    EXPECT_FALSE(
        builder.choose({flat, {{0, 0, 2}, {1, 1, 2}}, {}}, counters));  // A cell without thickness
    EXPECT_FALSE(
        builder.choose({flat, {{0, 0, 2}, {1, 0, 2}}, {}}, counters));  // A cell without area
  }
}

/// A floor with walls standing on it: the floor gets a flat cell at the face of the cell, on the
/// side without walls.
TEST(ExactBuilder, SeparatesTheFloorFromTheWalls) {
  std::vector<kdtree::Reference> refs;
  for (int i = 0; i < 20; ++i) {
    const auto x = static_cast<float>(i);
    refs.push_back(box_ref({x, 0, 0}, {x + 1, 20, 0}));             // A strip of floor
    refs.push_back(box_ref({0, x / 20, 0}, {20, x / 20 + 10, 5}));  // A slanted wall
  }
  for (const ExactSearch search : tests::kExactSearches) {
    const ExactBuilder builder{.search = search};
    kdtree::BuildCounters counters;
    const auto cut = builder.choose({refs, bounds_of(refs), {}}, counters);
    ASSERT_TRUE(cut);
    EXPECT_EQ(*cut, (kdtree::Split{.plane = {2, 0}, .planar_left = true}));
    std::vector<kdtree::Reference> left(refs.size()), right(refs.size());
    const kdtree::PartitionCounts n = kdtree::sift(refs, *cut, left.data(), right.data());
    EXPECT_EQ(n.left, 20u);
    EXPECT_EQ(n.right, 20u);
    EXPECT_FALSE(
        builder.choose({std::span(right).first(n.right), {{0, 0, 0}, {20, 20, 5}}, {}}, counters)
            .value_or(kdtree::Split{})
            .planar_left);  // No reference is left in the face
  }
}

/// "An axis-aligned triangle in the middle of a voxel should result in two splits, generating two
/// empty voxels and one flat, nonempty cell" (section 3.5).
TEST(ExactBuilder, CutsAWallInTheMiddleTwice) {
  std::vector<kdtree::Reference> refs(10, box_ref({0, 0, 4}, {9, 9, 4}));
  geometry::Aabb cell{{0, 0, 0}, {9, 9, 9}};
  for (const ExactSearch search : tests::kExactSearches) {
    kdtree::BuildCounters counters;
    const ExactBuilder builder{.search = search};
    const auto first = builder.choose({refs, cell, {}}, counters);
    ASSERT_TRUE(first);
    // The larger part, above the wall, is empty.
    EXPECT_EQ(*first, (kdtree::Split{.plane = {2, 4}, .planar_left = true}));
    const geometry::Aabb below = halve(cell, 2, 4).left;
    const auto second = builder.choose({refs, below, {}}, counters);
    ASSERT_TRUE(second);
    EXPECT_EQ(*second, (kdtree::Split{.plane = {2, 4}, .planar_left = false}));
    EXPECT_FALSE(builder.choose({refs, halve(below, 2, 4).right, {}}, counters));
  }
}

TEST(ExactBuilder, MakesAtMostTheAllowedUnprofitableCuts) {
  // Two boxes that overlap almost completely: no cut pays.
  const std::vector<kdtree::Reference> refs{box_ref({0, 0, 0}, {1, 1, 1}),
                                            box_ref({0.1f, 0, 0}, {1, 1, 1})};
  for (const ExactSearch search : tests::kExactSearches) {
    ExactBuilder builder{.search = search};
    kdtree::BuildCounters counters;
    EXPECT_FALSE(builder.choose({refs, bounds_of(refs), {}}, counters));
    builder.bad_refines = 2;
    for (const int used : {0, 1}) {
      const auto cut = builder.choose({refs, bounds_of(refs), {5, used}}, counters);
      ASSERT_TRUE(cut);
      EXPECT_TRUE(cut->at_a_loss);
      EXPECT_EQ((kdtree::CellPath{5, used}.below(*cut)), (kdtree::CellPath{6, used + 1}));
    }
    EXPECT_FALSE(builder.choose({refs, bounds_of(refs), {5, 2}}, counters));
  }
}

TEST(ExactBuilder, CheckNamesTheParameterAndItsRange) {
  ExactBuilder builder;
  EXPECT_FALSE(builder.check());
  builder.bad_refines = 17;
  EXPECT_EQ(*builder.check(), "bad_refines is 17, must lie in 0 to 16");
  builder = {};
  builder.costs.lambda = 0;
  EXPECT_TRUE(builder.check());
}

}  // namespace
}  // namespace sightline::accel::published::kd
