// Angles in double-doubles are those of long doubles, and add up to half a turn far more exactly.
#include "accel/geometry/angle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/random.h"

namespace sightline::accel::geometry {
namespace {

long double sum_of(const DoubleDouble& x) {
  return static_cast<long double>(x.high) + static_cast<long double>(x.low);
}

TEST(Angle, IsThatOfLongDoubles) {
  tests::Random random(1);
  for (int i = 0; i < 20'000; ++i) {
    const double sine = std::ldexp(random.uniform(), -static_cast<int>(random.below(80)));
    const double cosine = std::ldexp(random.uniform(-1, 1), -static_cast<int>(random.below(80)));
    const long double expected =
        std::atan2(static_cast<long double>(sine), static_cast<long double>(cosine));
    const long double angle = sum_of(angle_of({sine}, {cosine}));
    ASSERT_LE(std::fabs(angle - expected),
              2 * std::numeric_limits<long double>::epsilon() * expected)
        << sine << " " << cosine;
  }
}

TEST(Angle, OfTheAxesIsExact) {
  EXPECT_EQ(sum_of(angle_of({0}, {3})), 0);
  EXPECT_EQ(sum_of(angle_of({0}, {-3})), sum_of(kPi));
  EXPECT_EQ(sum_of(angle_of({0}, {0})), 0);
}

TEST(Angle, OfTheCornersOfATriangleAddUp) {
  tests::Random random(2);
  for (int i = 0; i < 5'000; ++i) {
    const double x = random.uniform(-1, 2), y = random.uniform() + 0x1p-40;
    // Corners (0, 0), (1, 0), (x, y).
    const DoubleDouble area{y}, apex_x = two_sum(1, -x);
    const DoubleDouble cosine_of_apex = two_product(x, x) + DoubleDouble{-x} + two_product(y, y);
    const DoubleDouble sum =
        angle_of(area, {x}) + angle_of(area, apex_x) + angle_of(area, cosine_of_apex);
    ASSERT_LE(std::fabs((sum - kPi).high), 0x1p-90) << x << " " << y;
  }
}

}  // namespace
}  // namespace sightline::accel::geometry
