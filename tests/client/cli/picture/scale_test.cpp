// The scale beside a picture: its numbers, its unit and its place.
#include "client/cli/picture/scale.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "client/cli/picture/font.h"

namespace sightline::client::cli::picture {
namespace {

TEST(Scale, TicksAreRoundNumbersWithinTheRange) {
  EXPECT_EQ(ticks_of({0, 10}, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(ticks_of({3.1, 7.9}, 5), (std::vector<double>{4, 5, 6, 7}));
  EXPECT_EQ(ticks_of({-20, 30}, 5), (std::vector<double>{-20, -10, 0, 10, 20, 30}));
  EXPECT_EQ(ticks_of({5, 5}, 5), std::vector<double>{});
  for (const double size : {1e-12, 0.7, 31.0, 4e9}) {
    const auto ticks = ticks_of({0, size}, 6);
    EXPECT_GE(ticks.size(), 4U) << size;
    EXPECT_LE(ticks.size(), 8U) << size;
  }
}

TEST(Scale, DistancesHaveTheUnitThatReadsBest) {
  EXPECT_EQ(depth_scale({1, 9}, 0).unit, "units");
  EXPECT_EQ(depth_scale({1, 9}, 0).range.high, 9);
  EXPECT_EQ(depth_scale({1, 9}, 0.3).unit, "m");
  EXPECT_DOUBLE_EQ(depth_scale({1, 9}, 0.3).range.high, 2.7);
  EXPECT_EQ(depth_scale({1, 9}, 0.001).unit, "mm");
  EXPECT_DOUBLE_EQ(depth_scale({1, 9}, 0.001).range.low, 1);
  EXPECT_EQ(depth_scale({1, 90'000}, 1).unit, "km");
  EXPECT_DOUBLE_EQ(depth_scale({1, 90'000}, 1).range.high, 90);
}

TEST(Scale, TheFontHasWhatScalesSay) {
  const Scale heat = heat_scale({});
  std::string words =
      "0123456789.-+e distance clearance units m mm km grey is alone hatched is no answer " +
      heat.title + heat.unit;
  for (const std::string& note : heat.notes) words += note;
  std::erase(words, ' ');
  for (const char c : words) EXPECT_NE(glyph_of(c), Glyph{}) << c;
}

TEST(Scale, TakesTheLastColumnsAndLeavesTheViewAsItIs) {
  const PictureSize size{640, 480};
  const std::uint32_t width = scale_width(size);
  ASSERT_GT(width, 0U);
  const std::size_t view_width = size.width - width;
  const std::vector<std::uint8_t> view(3 * view_width * size.height, 7);
  const auto rgb = beside_scale(view, size, heat_scale({0, 300}));
  ASSERT_EQ(rgb.size(), std::size_t{3} * size.width * size.height);
  std::size_t of_view = 0, dark = 0;
  for (std::size_t y = 0; y < size.height; ++y) {
    for (std::size_t x = 0; x < size.width; ++x) {
      const std::uint8_t red = rgb[3 * (y * size.width + x)];
      if (x < view_width && red == 7) ++of_view;
      if (x >= view_width && red < 100) ++dark;
    }
  }
  EXPECT_EQ(of_view, view_width * size.height);
  EXPECT_GT(dark, 500U) << "letters, ticks, and the dark end of the colours";
}

TEST(Scale, NotesThatDoNotFitAreLeftOut) {
  const PictureSize size{300, 100};
  Scale scale = depth_scale({0, 9}, 1);
  scale.notes = {"a", "b"};
  const std::vector<std::uint8_t> view(std::size_t{3} * (300 - scale_width(size)) * 100, 7);
  const auto with_two = beside_scale(view, size, scale);
  scale.notes = {"a", "b", "c", "d"};
  EXPECT_EQ(beside_scale(view, size, scale), with_two);
}

TEST(Scale, ASmallPictureHasNone) {
  EXPECT_EQ(scale_width({20, 10}), 0U);
  EXPECT_EQ(scale_width({200, 480}), 0U);
  EXPECT_EQ(scale_width({8192, 60}), 0U);
  EXPECT_GT(scale_width({8192, 8192}), 0U);
}

}  // namespace
}  // namespace sightline::client::cli::picture
