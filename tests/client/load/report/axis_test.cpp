// Positions and ticks.
#include "client/load/report/axis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/load/report/text.h"

namespace sightline::client::load::report {
namespace {

std::vector<std::string> labels(const Axis& axis) {
  std::vector<std::string> all;
  for (const Tick& tick : axis.ticks()) all.push_back(tick.label);
  return all;
}

using Labels = std::vector<std::string>;

TEST(Axis, ALinearOneHasRoundTicksFromZero) {
  const Axis axis = Axis::linear(3, 9.1, short_number);
  EXPECT_EQ(labels(axis), (Labels{"0", "2", "4", "6", "8", "10"}));
  EXPECT_DOUBLE_EQ(axis.position(0), 0);
  EXPECT_DOUBLE_EQ(axis.position(5), 0.5);
  EXPECT_DOUBLE_EQ(axis.position(50), 1);
}

TEST(Axis, OfNothingHasTicksToo) {
  EXPECT_GE(Axis::linear(0, 0, short_number).ticks().size(), 2u);
  EXPECT_TRUE(std::isfinite(Axis::logarithmic(5, 5, short_number).position(5)));
}

TEST(Axis, ALogarithmicOneHasDecades) {
  const Axis axis = Axis::logarithmic(1, 10'000, short_number);
  EXPECT_EQ(labels(axis), (Labels{"1", "10", "100", "1 k", "10 k"}));
  EXPECT_NEAR(axis.position(100), 0.5, 1e-12);
}

TEST(Axis, AShortLogarithmicOneHasTicksBetween) {
  EXPECT_EQ(labels(Axis::logarithmic(1, 10, short_number)), (Labels{"1", "2", "5", "10"}));
}

TEST(Axis, ALogarithmicOneWithoutRoundNumbersIsLinear) {
  const Axis axis = Axis::logarithmic(1.2, 1.7, short_number);
  EXPECT_GE(axis.ticks().size(), 2u);
  EXPECT_DOUBLE_EQ(axis.position(0), 0);
}

TEST(Axis, GivenTicksEndWithTheAxis) {
  const Axis axis = Axis::with_ticks({{0, "none"}, {1, "one"}, {2, "two"}}, 1.5);
  EXPECT_EQ(labels(axis), (Labels{"none", "one"}));
  EXPECT_DOUBLE_EQ(axis.position(0.75), 0.5);
}

}  // namespace
}  // namespace sightline::client::load::report
