// Palettes and light.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "client/cli/picture/shading.h"

namespace sightline::client::cli::picture {
namespace {

float luminance(const Rgb& c) { return 0.2126F * c[0] + 0.7152F * c[1] + 0.0722F * c[2]; }

TEST(Palette, HeatGetsLighterAndDepthDarker) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_LT(luminance(heat_colour(i / 100.0)), luminance(heat_colour((i + 1) / 100.0))) << i;
    EXPECT_GT(luminance(depth_colour(i / 100.0)), luminance(depth_colour((i + 1) / 100.0))) << i;
  }
}

TEST(Palette, ClearanceIsDarkWhereItIsSmallForEveryEye) {
  for (int i = 0; i < 100; ++i) {
    const Rgb near = clearance_colour(i / 100.0), far = clearance_colour((i + 1) / 100.0);
    EXPECT_LT(luminance(near), luminance(far)) << i;
    // Nor does the order depend on red, of which some eyes see little.
    EXPECT_LT(near[1] + near[2], far[1] + far[2] + 0.01F) << i;
  }
  const Rgb touching = clearance_colour(0), far = clearance_colour(1);
  EXPECT_GT(touching[0], 4 * std::max(touching[1], touching[2])) << "red";
  EXPECT_GT(luminance(far), 10 * luminance(touching));
}

TEST(Palette, ClearanceHasNoBands) {
  for (int i = 0; i < 250; ++i) {
    const Rgb here = clearance_colour(i / 250.0), next = clearance_colour((i + 1) / 250.0);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_LE(std::abs(encode_srgb(here[k]) - encode_srgb(next[k])), 3) << i;
  }
}

TEST(Palette, WithoutAnythingElseClearanceIsGrey) {
  const Rgb alone = clearance_shade({std::numeric_limits<float>::infinity(), 1}, {0, 9});
  EXPECT_NEAR(alone[0], alone[1], 1e-3);
  EXPECT_NEAR(alone[1], alone[2], 1e-3);
  EXPECT_EQ(clearance_shade({99, 1}, {0, 9}), clearance_shade({9, 1}, {0, 9}));
  EXPECT_LT(luminance(clearance_shade({5, 0}, {0, 9})), luminance(clearance_shade({5, 1}, {0, 9})));
}

TEST(Palette, ValuesOutsideTheRampAreClamped) {
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

float brightness(const Rgb& c) { return c[0] + c[1] + c[2]; }

TEST(Shading, NormalsFaceTheRay) {
  EXPECT_EQ(facing({0, 0, 1}, {0, 0, -1}), (Vec3{0, 0, 1}));
  EXPECT_EQ(facing({0, 0, -1}, {0, 0, -1}), (Vec3{0, 0, 1}));
}

TEST(Shading, UpLooksTheSameForBothAxes) {
  const Camera y_camera;  // Looks along -z, y up
  Camera z_camera;
  z_camera.forward = {0, 1, 0};
  z_camera.up = {0, 0, 1};
  z_camera.scene = upright_axes({0, 0, 1});
  EXPECT_EQ(normal_shade({0, 1, 0}, y_camera), normal_shade({0, 0, 1}, z_camera));
}

TEST(Shading, ShadowsAreDarkerAndNotBlack) {
  const Camera camera;
  const Vec3 sun{0, 1, 0}, up{0, 1, 0};
  const Rgb lit = sun_shade(up, sun, false, camera), shadow = sun_shade(up, sun, true, camera);
  EXPECT_GT(luminance(lit), 2 * luminance(shadow));
  EXPECT_GT(luminance(shadow), 0.1F);
  EXPECT_LE(luminance(lit), 1.0F);
  EXPECT_EQ(sun_shade({0, -1, 0}, sun, false, camera), sun_shade({0, -1, 0}, sun, true, camera));
}

TEST(Shading, DepthGoesFromNearToFarAndMissesAreDark) {
  std::vector<Sample> samples(101, Sample{0, 1, false});
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].value = static_cast<float>(i);
  samples.push_back({1e9F, -1, false});
  const ValueRange range = depth_range(samples);
  EXPECT_EQ(range.low, 1);
  EXPECT_EQ(range.high, 99);
  const auto colours = depth_shades(samples, range);
  ASSERT_EQ(colours.size(), samples.size());
  EXPECT_GT(brightness(colours[10]), brightness(colours[50]));
  EXPECT_GT(brightness(colours[50]), brightness(colours[90]));
  EXPECT_LT(brightness(colours.back()), brightness(colours[100]));
}

TEST(Shading, HeatOfDeferredCellsIsDark) {
  const std::vector<Sample> samples{
      {40, 0.5F, false}, {40, -1, false}, {40, -1, true}, {10, 0.5F, false}};
  const auto colours = heat_shades(samples, heat_range(samples));
  EXPECT_GT(brightness(colours[0]), brightness(colours[3]));
  EXPECT_LT(brightness(colours[2]), 0.5F * brightness(colours[1]));
  EXPECT_LT(brightness(colours[2]), 0.5F * brightness(colours[0]));
}

TEST(Shading, AnEmptyPictureHasColors) {
  const std::vector<Sample> miss{{0, -1, false}};
  EXPECT_EQ(depth_shades(miss, depth_range(miss)).size(), 1U);
  EXPECT_EQ(heat_shades(miss, heat_range(miss)).size(), 1U);
  EXPECT_TRUE(depth_shades({}, depth_range({})).empty());
}

}  // namespace

}  // namespace sightline::client::cli::picture
