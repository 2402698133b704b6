// Object splits: sorted lists stay sorted, and no split is cheaper than the chosen one.
#include "accel/published/bvh/object_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "tests/accel/boxes.h"
#include "tests/accel/published/bvh/fragments.h"

namespace sightline::accel::published::bvh {
namespace {

using tests::SortedFragments;

double sum_of(std::span<const Fragment> list, std::size_t left) {
  geometry::Aabb l, r;
  for (std::size_t i = 0; i < list.size(); ++i) (i < left ? l : r).grow(list[i].bounds());
  return half_area(l) * static_cast<double>(left) +
         half_area(r) * static_cast<double>(list.size() - left);
}

/// Every index along every axis, computed directly.
double least_sum(const std::vector<kdtree::Reference>& refs) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<Fragment> list;
    for (std::uint32_t i = 0; i < refs.size(); ++i) {
      list.emplace_back(refs[i].bounds(), refs[i].id, i);
    }
    std::sort(list.begin(), list.end(),
              [&](const Fragment& a, const Fragment& b) { return precedes(a, b, axis); });
    for (std::size_t left = 1; left < list.size(); ++left)
      least = std::min(least, sum_of(list, left));
  }
  return least;
}

ObjectSplit best(const CenterLists& lists) {
  SweepAreas areas;
  kdtree::BuildCounters counters;
  return best_object_split(lists, areas, counters);
}

TEST(CenterLists, AreSortedAlongEachAxis) {
  for (const std::size_t n : {0u, 1u, 2u, 100u, 5000u}) {
    const std::vector<kdtree::Reference> refs = tests::lattice_boxes(n, 1, n);
    const SortedFragments sorted(refs);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(sorted.lists.along[axis].size(), n);
      EXPECT_TRUE(tests::is_sorted_along(sorted.lists.along[axis], axis));
    }
    EXPECT_EQ(sorted.lists.box, kdtree::bounds_of(refs));
  }
}

TEST(CenterLists, DoNotDependOnTheOrderOfTheInput) {
  std::vector<kdtree::Reference> refs = tests::lattice_boxes(300, 1, 3);
  const SortedFragments ascending(refs);
  std::reverse(refs.begin(), refs.end());
  const SortedFragments descending(refs);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < refs.size(); ++i) {
      const Fragment &a = ascending.lists.along[axis][i], &b = descending.lists.along[axis][i];
      ASSERT_EQ(a.id(), b.id());
      ASSERT_EQ(a.bounds(), b.bounds());
    }
  }
}

TEST(CenterLists, AreDividedAtAnIndexInTheirOrder) {
  for (const std::size_t n : {2u, 3u, 50u, 9000u}) {
    for (const std::size_t axis : {0u, 1u, 2u}) {
      for (const std::size_t left : {std::size_t{1}, n / 2, n - 1}) {
        SortedFragments sorted(tests::lattice_boxes(n, 1, n));
        std::set<std::uint32_t> expected;
        for (const Fragment& f : sorted.lists.along[axis].first(left)) expected.insert(f.order());
        const ListHalves halves =
            divide_by_centers(sorted.lists, axis, left, sorted.stack, sorted.counters);
        for (std::size_t a = 0; a < 3; ++a) {
          ASSERT_EQ(halves.left.along[a].size(), left);
          ASSERT_EQ(halves.right.along[a].size(), n - left);
          ASSERT_TRUE(tests::is_sorted_along(halves.left.along[a], a));
          ASSERT_TRUE(tests::is_sorted_along(halves.right.along[a], a));
          for (const Fragment& f : halves.left.along[a]) ASSERT_TRUE(expected.contains(f.order()));
        }
        EXPECT_EQ(halves.left.box, box_around(halves.left.along[axis]));
        EXPECT_EQ(halves.right.box, box_around(halves.right.along[axis]));
      }
    }
  }
}

TEST(ObjectSplit, IsTheCheapestOfAll) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const std::vector<kdtree::Reference> refs = seed % 2 == 0
                                                    ? tests::random_boxes(2 + seed, 0.2, seed)
                                                    : tests::lattice_boxes(2 + seed, 1, seed);
    const SortedFragments sorted(refs);
    const ObjectSplit split = best(sorted.lists);
    const double whole = half_area(sorted.lists.box) * static_cast<double>(refs.size());
    const double least = least_sum(refs);
    if (!split.found()) {
      EXPECT_NEAR(least, whole, 1e-9 * whole);
      continue;
    }
    EXPECT_DOUBLE_EQ(split.sum, least);
    EXPECT_DOUBLE_EQ(split.sum, sum_of(sorted.lists.along[split.axis], split.left));
  }
}

TEST(ObjectSplit, OfALongListIsTheBestOfEachAxis) {
  const std::vector<kdtree::Reference> refs = tests::random_boxes(6000, 0.05, 9);
  const SortedFragments sorted(refs);
  const ObjectSplit split = best(sorted.lists);
  ASSERT_TRUE(split.found());
  EXPECT_DOUBLE_EQ(split.sum, sum_of(sorted.lists.along[split.axis], split.left));
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t left = 50; left < refs.size(); left += 50)
      least = std::min(least, sum_of(sorted.lists.along[axis], left));
  }
  EXPECT_LE(split.sum, least);
}

TEST(ObjectSplit, IsNoneIfNothingSeparates) {
  std::vector<kdtree::Reference> same;
  for (std::uint32_t i = 0; i < 20; ++i) same.push_back(tests::box_ref({0, 0, 0}, {1, 2, 3}, i));
  const SortedFragments sorted(same);
  EXPECT_FALSE(best(sorted.lists).found());
  const ObjectSplit middle = middle_split(sorted.lists);
  EXPECT_EQ(middle.axis, 2u);
  EXPECT_EQ(middle.left, 10u);
  EXPECT_FALSE(best(SortedFragments({}).lists).found());
  EXPECT_FALSE(best(SortedFragments({same[0]}).lists).found());
}

}  // namespace
}  // namespace sightline::accel::published::bvh
