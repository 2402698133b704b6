// Where a curve falls below another.
#include "client/load/crossover.h"

#include <gtest/gtest.h>

#include <vector>

namespace sightline::client::load {
namespace {

using Curve = std::vector<Point>;

TEST(Crossover, IsWhereLinesCross) {
  const Curve lazy{{0, 1}, {10, 11}}, full{{0, 6}, {10, 6}};
  ASSERT_TRUE(crossover(lazy, full));
  EXPECT_DOUBLE_EQ(*crossover(lazy, full), 5);
}

TEST(Crossover, IsNowhereIfTheRivalStaysAbove) {
  EXPECT_FALSE(crossover(Curve{{0, 1}, {10, 2}}, Curve{{0, 3}, {10, 4}}));
}

TEST(Crossover, IsAtTheBeginningIfTheRivalIsNeverAbove) {
  EXPECT_EQ(crossover(Curve{{2, 5}, {10, 5}}, Curve{{0, 3}, {8, 4}}), 2);
}

TEST(Crossover, TheLastOfSeveralCounts) {
  const Curve lazy{{0, 5}, {1, 5}, {2, 5}, {3, 5}, {4, 5}},
      full{{0, 6}, {1, 4}, {2, 6}, {3, 4}, {4, 4}};
  EXPECT_DOUBLE_EQ(*crossover(lazy, full), 2.5);
}

TEST(Crossover, ARivalThatIsLittleAboveCounts) {
  const Curve lazy{{0, 10}, {10, 20}}, full{{0, 20.9}, {10, 20.9}};
  EXPECT_FALSE(crossover(lazy, full));
  ASSERT_TRUE(crossover(lazy, full, 1.1));
  EXPECT_DOUBLE_EQ(*crossover(lazy, full, 1.1), 9);
}

TEST(Crossover, NeedsPointsInCommon) {
  EXPECT_FALSE(crossover(Curve{}, Curve{{0, 1}}));
  EXPECT_FALSE(crossover(Curve{{0, 2}, {1, 2}}, Curve{{2, 1}, {3, 1}}));
}

TEST(Crossover, ValuesAreLinearBetweenPoints) {
  const Curve curve{{1, 10}, {3, 20}};
  EXPECT_DOUBLE_EQ(value_at(curve, 1), 10);
  EXPECT_DOUBLE_EQ(value_at(curve, 2), 15);
  EXPECT_DOUBLE_EQ(value_at(curve, 3), 20);
}

}  // namespace
}  // namespace sightline::client::load
