// The colours and lines of a slice.
#include "client/cli/picture/slice.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "client/cli/picture/font.h"

namespace sightline::client::cli::picture {
namespace {

constexpr std::uint32_t kWidth = 201;
using Colour = std::array<int, 3>;

// Distances from -100 to 100, one more from each pixel to the next.
Slice ramp() {
  Slice slice{{kWidth, 3}, 1, {}, {}};
  for (std::uint32_t y = 0; y < 3; ++y) {
    for (std::uint32_t x = 0; x < kWidth; ++x) slice.distances.push_back(x - 100.0);
  }
  return slice;
}

Colour pixel(const std::vector<std::uint8_t>& rgb, std::size_t x) {
  const std::size_t at = 3 * (kWidth + x);
  return {rgb[at], rgb[at + 1], rgb[at + 2]};
}

int sum(const Colour& colour) { return colour[0] + colour[1] + colour[2]; }

TEST(Slice, IsBlueInsideAndRedOutsideAndBlackBetween) {
  const auto rgb = paint_slice(ramp(), {.range = 100});
  for (std::size_t x = 0; x < kWidth; ++x) {
    const auto [red, green, blue] = pixel(rgb, x);
    if (x < 98) {
      EXPECT_GT(blue, red) << x;
    } else if (x > 102) {
      EXPECT_GT(red, blue) << x;
    }
  }
  EXPECT_EQ(pixel(rgb, 100), (Colour{0, 0, 0}));
  EXPECT_LT(sum(pixel(rgb, 0)), sum(pixel(rgb, 50))) << "darker away from the surface";
  EXPECT_LT(sum(pixel(rgb, 200)), sum(pixel(rgb, 150)));
  EXPECT_GT(sum(pixel(rgb, 97)), 650) << "nearly white beside it";
}

TEST(Slice, LinesAreAtMultiplesOfTheStepAlone) {
  const auto plain = paint_slice(ramp(), {.range = 100});
  const auto lined = paint_slice(ramp(), {.range = 100, .iso = 20});
  for (std::size_t x = 0; x < kWidth; ++x) {
    const bool is_line = x % 20 == 0 && x != 100;
    const bool is_between = x % 20 > 1 && x % 20 < 19;
    if (is_line) {
      EXPECT_LT(sum(pixel(lined, x)), sum(pixel(plain, x)) * 3 / 4) << x;
    } else if (is_between) {
      EXPECT_EQ(pixel(lined, x), pixel(plain, x)) << x;
    }
  }
}

TEST(Slice, WithoutSidesColoursAreThoseOfOutside) {
  Slice slice = ramp();
  for (double& distance : slice.distances) distance = std::abs(distance);
  const auto rgb = paint_slice(slice, {.is_signed = false, .range = 100});
  EXPECT_EQ(pixel(rgb, 30), pixel(rgb, 170));
  EXPECT_GT(pixel(rgb, 30)[0], pixel(rgb, 30)[2]);
  EXPECT_EQ(pixel(rgb, 100), (Colour{0, 0, 0}));
}

TEST(Slice, NumbersThatAreNotFiniteHaveColours) {
  Slice slice{{3, 1}, 1, {std::nan(""), std::numeric_limits<double>::infinity(), 9}, {}};
  const auto rgb = paint_slice(slice, {.range = 9, .iso = 2});
  EXPECT_EQ(rgb[0], rgb[2]) << "grey";
  EXPECT_EQ(rgb[3], rgb[6]) << "as what is farther than the range";
}

TEST(Slice, PointsWithoutAnAnswerAreHatched) {
  Slice slice = ramp();
  for (std::size_t x = 40; x < 80; ++x)
    slice.distances[kWidth + x] = -std::numeric_limits<double>::infinity();
  const auto rgb = paint_slice(slice, {.range = 100, .iso = 20});
  std::size_t light = 0, dark = 0;
  for (std::size_t x = 40; x < 80; ++x) {
    const auto [red, green, blue] = pixel(rgb, x);
    EXPECT_TRUE(red == green && green == blue) << x;
    ++(red > 180 ? light : dark);
  }
  EXPECT_EQ(light, 20U);
  EXPECT_EQ(dark, 20U);
  EXPECT_EQ(pixel(rgb, 90), pixel(paint_slice(ramp(), {.range = 100, .iso = 20}), 90));
}

TEST(Slice, SidesDifferForThoseWhoSeeNoRed) {
  // Lightness is the same on both sides, so that the hue alone tells them: blue and not red, which
  // the common kinds of colour blindness tell from each other by the blue channel.
  for (const double s : {0.1, 0.3, 0.6, 1.0}) {
    const Rgb inside = side_colour(-s), outside = side_colour(s);
    EXPECT_GT(inside[2] - outside[2], 0.15F) << s;
  }
  for (int i = 0; i < 50; ++i) {
    const auto luminance = [](const Rgb& c) {
      return 0.2126F * c[0] + 0.7152F * c[1] + 0.0722F * c[2];
    };
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_GT(luminance(side_colour(sign * i / 50.0)),
                luminance(side_colour(sign * (i + 1) / 50.0)))
          << i;
    }
  }
}

TEST(Slice, TheRangeLeavesOutTheLargestFew) {
  std::vector<double> distances(1000, -2);
  distances[7] = 1e9;
  distances[8] = std::nan("");
  distances[9] = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(range_of(distances), 2);
  EXPECT_EQ(range_of({}), 1);
  EXPECT_EQ(range_of(std::vector<double>(5, 0)), 1);
}

TEST(Slice, TheScaleIsThatOfTheColours) {
  const Scale scale = slice_scale({.range = 50}, 0.001);
  EXPECT_EQ(scale.unit, "mm");
  EXPECT_DOUBLE_EQ(scale.range.low, -50);
  EXPECT_DOUBLE_EQ(scale.range.high, 50);
  EXPECT_EQ(scale.colour(scale.position(-50, scale.range)), side_colour(-1));
  EXPECT_EQ(scale.colour(scale.position(25, scale.range)), side_colour(0.5));
  EXPECT_EQ(slice_scale({.is_signed = false, .range = 50}, 0).range.low, 0);
  EXPECT_EQ(slice_scale({.is_signed = false, .range = 50}, 0).notes.size(), 0U);
  EXPECT_EQ(slice_scale({.is_signed = false, .range = 50}, 0, true).notes.size(), 2U);
  for (const std::string& note : slice_scale({.range = 50}, 0, true).notes) {
    for (const char c : note) EXPECT_TRUE(c == ' ' || glyph_of(c) != Glyph{}) << c;
  }
}

TEST(Slice, LinesKeepAFewPixelsBetweenThem) { EXPECT_EQ(least_iso({{100, 100}, 0.5, {}, {}}), 2); }

TEST(Slice, ASignThatTurnsFarFromASurfaceIsNoSurface) {
  Slice slice = ramp();
  slice.distances[kWidth + 150] = -50;
  const auto rgb = paint_slice(slice, {.range = 100});
  EXPECT_GT(pixel(rgb, 150)[2], pixel(rgb, 150)[0]) << "blue, not black";
  EXPECT_EQ(pixel(rgb, 149), pixel(paint_slice(ramp(), {.range = 100}), 149));
}

}  // namespace
}  // namespace sightline::client::cli::picture
