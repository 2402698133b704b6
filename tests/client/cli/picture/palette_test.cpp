// Ramps whose order can be seen, colours that can be told apart.
#include "client/cli/picture/palette.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace sightline::client::cli::picture {
namespace {

float luminance(const Rgb& c) { return 0.2126F * c[0] + 0.7152F * c[1] + 0.0722F * c[2]; }

TEST(Palette, HeatGetsLighterAndDepthDarker) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_LT(luminance(heat_colour(i / 100.0)), luminance(heat_colour((i + 1) / 100.0))) << i;
    EXPECT_GT(luminance(depth_colour(i / 100.0)), luminance(depth_colour((i + 1) / 100.0))) << i;
  }
}

TEST(Palette, OutsideTheRampAreItsEnds) {
  EXPECT_EQ(heat_colour(-1), heat_colour(0));
  EXPECT_EQ(heat_colour(2), heat_colour(1));
}

TEST(Palette, NeighbouringNodesDifferAndANodeStaysTheSame) {
  EXPECT_EQ(node_colour(42), node_colour(42));
  for (std::uint64_t id = 1; id < 1000; ++id) {
    const Rgb a = node_colour(id);
    const Rgb b = node_colour(id + 1);
    int difference = 0;
    for (std::size_t k = 0; k < 3; ++k)
      difference += std::abs(encode_srgb(a[k]) - encode_srgb(b[k]));
    EXPECT_GT(difference, 40) << id;
  }
}

TEST(Palette, EncodesTheEndsAndTheMiddle) {
  EXPECT_EQ(encode_srgb(0), 0);
  EXPECT_EQ(encode_srgb(1), 255);
  EXPECT_EQ(encode_srgb(2), 255);
  EXPECT_EQ(encode_srgb(-1), 0);
  EXPECT_EQ(encode_srgb(0.2158605F), 128);
}

TEST(Palette, WhiteIsWhite) {
  for (const float channel : from_oklch(1, 0, 0)) EXPECT_NEAR(channel, 1, 1e-3);
}

}  // namespace
}  // namespace sightline::client::cli::picture
