// Pixels, each once.
#include "client/cli/picture/sampling.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

namespace sightline::client::cli::picture {
namespace {

TEST(Sampling, EveryPixelOnceInTiles) {
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

}  // namespace
}  // namespace sightline::client::cli::picture
