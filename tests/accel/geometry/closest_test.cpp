// The distance rule against exact arithmetic: rounded once, for every kind of point and face.
#include "accel/geometry/closest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/accel/geometry/closest_cases.h"

namespace sightline::accel::geometry {
namespace {

constexpr std::array<double, 12> kNoTransform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

class EveryFamily : public testing::TestWithParam<ClosestFamily> {};

TEST_P(EveryFamily, DistanceIsRoundedOnce) {
  tests::Random random(21);
  for (int round = 0; round < 2000; ++round) {
    const ClosestCase c = GetParam().make(random);
    ASSERT_TRUE(is_rounded_distance(c, c.distance())) << "round " << round;
  }
}

/// Neighbours that share the nearest edge or corner have the same distance for this reason.
TEST_P(EveryFamily, OrderOfCornersDoesNotMatter) {
  tests::Random random(22);
  for (int round = 0; round < 500; ++round) {
    ClosestCase c = GetParam().make(random);
    const double d = c.distance();
    const auto [a, b, e] = c.vertices;
    for (const auto& vertices : {std::array{b, e, a}, {e, a, b}, {a, e, b}, {e, b, a}, {b, a, e}}) {
      c.vertices = vertices;
      ASSERT_EQ(c.distance(), d) << "round " << round;
    }
  }
}

TEST_P(EveryFamily, NearestPointAndWeightsAreRight) {
  tests::Random random(23);
  for (int round = 0; round < 1000; ++round) {
    const ClosestCase c = GetParam().make(random);
    ASSERT_EQ(fault_of(c, c.closest_point()), "") << "round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(Closest, EveryFamily, testing::ValuesIn(closest_families()),
                         [](const auto& family) { return family.param.name; });

TEST(Closest, IsZeroOnTheFaceAndNowhereElse) {
  tests::Random random(24);
  for (const ClosestFamily& family : closest_families()) {
    if (family.name != "exactly_on") continue;
    for (int round = 0; round < 2000; ++round) {
      const ClosestCase c = family.make(random);
      ASSERT_EQ(c.distance(), 0.0);
      ASSERT_EQ(c.closest_point().position, c.p);
    }
  }
  const Vec3f a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
  EXPECT_EQ(distance({0.25, 0.25, 0x1p-250}, kNoTransform, a, b, c), 0x1p-250);
  EXPECT_EQ(distance({0.25, 0.25, 0x1p-251}, kNoTransform, a, b, c), 0.0);
  EXPECT_EQ(distance({-0x1p-250, 0.25, 0}, kNoTransform, a, b, c), 0x1p-250);
}

TEST(Closest, TiesGoToTheEvenNeighbour) {
  const Vec3f a{-0.5f, 0, 0}, b{-0.5f, 1, 0}, c{-0.5f, 0, 1};
  EXPECT_EQ(distance({0x1p+52 + 1, 0.25, 0.25}, kNoTransform, a, b, c), 0x1p+52 + 2);
  EXPECT_EQ(distance({0x1p+52 + 2, 0.25, 0.25}, kNoTransform, a, b, c), 0x1p+52 + 2);
  EXPECT_EQ(distance({0x1p+52 + 1, 0, 0}, kNoTransform, a, a, a), 0x1p+52 + 2);
  EXPECT_EQ(distance({0x1p+52 + 2, 0, 0.5}, kNoTransform, a, a, c), 0x1p+52 + 2);
}

TEST(Closest, RangesOfDoublesAreNotLeft) {
  const Vec3f a{0x1p+127f, 0, 0}, b{0x1p-149f, 0, 0};
  std::array<double, 12> m{};
  m[0] = 0x1p+1000;
  EXPECT_EQ(distance({0, 0, 0}, m, a, a, a), std::numeric_limits<double>::infinity());
  m[0] = 0x1p-1000;
  EXPECT_EQ(distance({0, 0, 0}, m, b, b, b), 0.0);
  EXPECT_EQ(distance({0, 0, 0}, m, a, a, a), 0x1p-873);
  m[0] = 0x1p-1074;
  EXPECT_EQ(distance({0, 0, 0}, m, {3, 0, 0}, {3, 0, 0}, {3, 0, 0}), 0x3p-1074);
}

TEST(Closest, FacesWithoutAreaAreSegmentsAndPoints) {
  const Vec3f a{0, 0, 0}, b{4, 0, 0}, c{2, 0, 0};
  EXPECT_EQ(distance({1, 3, 0}, kNoTransform, a, b, c), 3);
  EXPECT_EQ(distance({7, 4, 0}, kNoTransform, c, a, b), 5);
  EXPECT_EQ(distance({5, 0, 0}, kNoTransform, c, c, c), 3);
  EXPECT_EQ(distance({3, 0, 2}, kNoTransform, a, b, b), 2);
  const ClosestPoint half = closest_point({3, 0, 2}, kNoTransform, a, b, b);
  EXPECT_EQ(half.position, (Vec3d{3, 0, 0}));
  EXPECT_EQ(half.u, 0.75);
  EXPECT_EQ(half.v, 0);
}

}  // namespace
}  // namespace sightline::accel::geometry
