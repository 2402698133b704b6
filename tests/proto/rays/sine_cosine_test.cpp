// Sine and cosine against the C library's in extended precision.
#include "proto/rays/sine_cosine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "proto/rays/generator.h"
#include "tests/support/random.h"

namespace sightline::proto::rays {
namespace {

constexpr long double kBound = 0x1p-52L;

void expect_close(double angle) {
  const SineCosine found = sine_cosine(angle);
  const auto exact = static_cast<long double>(angle);
  EXPECT_LE(std::abs(static_cast<long double>(found.sine) - std::sin(exact)), kBound) << angle;
  EXPECT_LE(std::abs(static_cast<long double>(found.cosine) - std::cos(exact)), kBound) << angle;
}

TEST(SineCosine, IsCloseEverywhere) {
  tests::Random random(1);
  for (int i = 0; i < 200000; ++i) expect_close(random.uniform(-kMaxAngle, kMaxAngle));
  for (int k = -40; k <= 40; ++k) {
    const double multiple = k * std::numbers::pi / 4;
    expect_close(multiple);
    expect_close(std::nextafter(multiple, 100));
    expect_close(std::nextafter(multiple, -100));
  }
}

TEST(SineCosine, HasTheQuartersOfATurn) {
  EXPECT_EQ(sine_cosine(0).sine, 0);
  EXPECT_EQ(sine_cosine(0).cosine, 1);
  EXPECT_EQ(sine_cosine(std::numbers::pi / 2).sine, 1);
  EXPECT_EQ(sine_cosine(std::numbers::pi).cosine, -1);
  EXPECT_EQ(sine_cosine(-std::numbers::pi / 2).sine, -1);
}

TEST(SineCosine, HasTheseBits) {
  EXPECT_EQ(sine_cosine(1).sine, 0x1.aed548f090ceep-1);
  EXPECT_EQ(sine_cosine(1).cosine, 0x1.14a280fb5068cp-1);
}

}  // namespace
}  // namespace sightline::proto::rays
