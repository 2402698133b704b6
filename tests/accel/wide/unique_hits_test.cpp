// Lists that keep each hit once, or the nearest hit.
#include "accel/wide/unique_hits.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/random.h"

namespace sightline::accel::wide {
namespace {

TEST(UniqueHits, KeepsEachOnce) {
  tests::Random random(1);
  UniqueHits<std::uint32_t> list;
  for (int round = 0; round < 3; ++round) {
    list.clear();
    std::set<std::uint32_t> expected;
    for (int i = 0; i < 20'000; ++i) {
      const auto x = static_cast<std::uint32_t>(random.below(3000));
      expected.insert(x);
      list.add(x);
    }
    const auto kept = list.sorted();
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), expected.begin(), expected.end()));
    EXPECT_EQ(list.greatest(), nullptr) << "there is no limit";
  }
}

TEST(UniqueHits, KeepsTheLeast) {
  for (const std::size_t limit : {1u, 2u, 31u, 32u, 33u, 100u}) {
    tests::Random random(limit);
    UniqueHits<std::uint32_t> list(limit);
    std::set<std::uint32_t> expected;
    for (int i = 0; i < 5000; ++i) {
      const auto x = static_cast<std::uint32_t>(random.below(1'000'000));
      expected.insert(x);
      if (list.add(x) && list.greatest() != nullptr) {
        // Its bound is never below the hit that will be kept.
        EXPECT_GE(*list.greatest(), *std::next(expected.begin(), static_cast<int>(limit) - 1));
      }
    }
    const auto kept = list.sorted();
    ASSERT_EQ(kept.size(), limit);
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), expected.begin()));
  }
}

TEST(ListedHit, IsOrderedByDistanceThenNodeThenPrimitive) {
  const ListedHit hit{1, 5, 7, 0};
  EXPECT_LT(hit, (ListedHit{2, 1, 1, 0}));
  EXPECT_LT(hit, (ListedHit{1, 6, 1, 0}));
  EXPECT_LT(hit, (ListedHit{1, 5, 8, 0}));
  EXPECT_EQ(hit, (ListedHit{1, 5, 7, 0}));
}

}  // namespace
}  // namespace sightline::accel::wide
