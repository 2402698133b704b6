// The order of the pixels, and PNG files.
#include <gtest/gtest.h>
#include <png.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/picture/film.h"
#include "client/cli/picture/picture.h"

namespace sightline::client::cli::picture {
namespace {

TEST(Sampling, VisitsEveryPixelOnceInTiles) {
  const auto pixels = tiled_pixels({21, 10});
  std::set<std::pair<int, int>> seen;
  for (const Pixel pixel : pixels) {
    EXPECT_LT(pixel.x, 21);
    EXPECT_LT(pixel.y, 10);
    seen.emplace(pixel.x, pixel.y);
  }
  EXPECT_EQ(pixels.size(), 210U);
  EXPECT_EQ(seen.size(), 210U);
  for (std::size_t i = 0; i < 64; ++i) EXPECT_TRUE(pixels[i].x < 8 && pixels[i].y < 8) << i;
}

TEST(Sampling, SamplesFillThePixelRowsAndColumns) {
  std::set<double> xs;
  std::set<double> ys;
  for (const auto& [x, y] : kSampleOffsets) {
    xs.insert(x);
    ys.insert(y);
  }
  EXPECT_EQ(xs, (std::set<double>{0.125, 0.375, 0.625, 0.875}));
  EXPECT_EQ(xs, ys);
}

TEST(Png, DecodesToTheSamePixels) {
  std::vector<std::uint8_t> rgb;
  for (int i = 0; i < 7 * 5 * 3; ++i) rgb.push_back(static_cast<std::uint8_t>(i * 37));
  const auto bytes = encode_png(rgb, 7, 5);
  ASSERT_TRUE(bytes) << bytes.error().message;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&image, bytes->data(), bytes->size()), 0);
  EXPECT_EQ(image.width, 7U);
  EXPECT_EQ(image.height, 5U);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> read(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, read.data(), 0, nullptr), 0);
  EXPECT_EQ(read, rgb);
}

}  // namespace

}  // namespace sightline::client::cli::picture
