// Vertices relative to the center are exact, and never denormal unless they were.
#include "accel/blocks/frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/random.h"

namespace sightline::accel::blocks {
namespace {

constexpr float kTiny = std::numeric_limits<float>::min();
constexpr float kMost = std::numeric_limits<float>::max();
constexpr float kLeastCenter = kTiny / std::numeric_limits<float>::epsilon();

float center_between(float lo, float hi) { return frame_center({{lo, lo, lo}, {hi, hi, hi}}).y; }

void expect_exact(float v, float center) {
  const float r = relative(v, center);
  ASSERT_EQ(static_cast<double>(r), static_cast<double>(v) - static_cast<double>(center))
      << v << " - " << center;
  ASSERT_TRUE(center == 0 || r == 0 || std::fabs(r) >= kTiny) << v << " - " << center;
}

TEST(Frame, IsTheNearerBoundWhereBoundsAreClose) {
  EXPECT_EQ(center_between(1, 2), 1);
  EXPECT_EQ(center_between(-2, -1), -1);
  EXPECT_EQ(center_between(5, 5), 5);
  EXPECT_EQ(center_between(1, std::nextafter(2.0f, 3.0f)), 0);
  EXPECT_EQ(center_between(-1, 1), 0);
  EXPECT_EQ(center_between(0, 1), 0);
  EXPECT_EQ(center_between(-1, 0), 0);
  EXPECT_EQ(center_between(kMost / 2, kMost), kMost / 2);
  EXPECT_EQ(center_between(-kMost, kMost), 0);
}

TEST(Frame, AxesAreIndependent) {
  const geometry::Vec3f center = frame_center({{1, -1, -6}, {2, 1, -4}});
  EXPECT_EQ(center, (geometry::Vec3f{1, 0, -4}));
}

TEST(Frame, OfEmptyBoundsIsTheOrigin) { EXPECT_EQ(frame_center({}), geometry::Vec3f()); }

TEST(Frame, HasNoCenterWhereDifferencesCouldBeDenormal) {
  EXPECT_EQ(center_between(kLeastCenter, kLeastCenter * 1.5f), kLeastCenter);
  const float below = std::nextafter(kLeastCenter, 0.0f);
  EXPECT_EQ(center_between(below, below * 1.5f), 0);
  EXPECT_EQ(center_between(kTiny, kTiny * 2), 0);
  expect_exact(std::nextafter(kLeastCenter, 1.0f), kLeastCenter);
}

TEST(Frame, DifferencesAreExact) {
  tests::Random random(1);
  std::size_t centered = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto lo = static_cast<float>(
        std::ldexp(random.uniform(1, 2), static_cast<int>(random.below(250)) - 125));
    const auto ratio = static_cast<float>(random.uniform(1, 2.2));
    const float hi = std::min(lo * ratio, kMost);
    const bool negative = random.below(2) == 1;
    const float center = negative ? center_between(-hi, -lo) : center_between(lo, hi);
    centered += center != 0 ? 1 : 0;
    for (const float v : {lo, hi, static_cast<float>(random.uniform(lo, hi)),
                          std::min(hi, std::nextafter(lo, hi)), std::nextafter(hi, lo)})
      expect_exact(negative ? -v : v, center);
  }
  EXPECT_GT(centered, 10000u);
}

TEST(Frame, KeepsWhatIsNotCentered) {
  const float denormal = kTiny / 4;
  EXPECT_EQ(relative(denormal, 0), denormal);
}

}  // namespace
}  // namespace sightline::accel::blocks
