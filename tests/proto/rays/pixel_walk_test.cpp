// The order of the pixels of a picture.
#include "proto/rays/pixel_walk.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace sightline::proto::rays {
namespace {

using Pixels = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

Pinhole picture(std::uint32_t width, std::uint32_t height, bool tiled) {
  Pinhole picture;
  picture.width = width;
  picture.height = height;
  picture.tiled = tiled;
  return picture;
}

/// Tile by tile, or row by row, by four loops.
Pixels expected(const Pinhole& picture) {
  const std::uint32_t tile_width = picture.tiled ? kTile : picture.width;
  const std::uint32_t tile_height = picture.tiled ? kTile : 1;
  Pixels pixels;
  for (std::uint32_t top = 0; top < picture.height; top += tile_height) {
    for (std::uint32_t left = 0; left < picture.width; left += tile_width) {
      for (std::uint32_t y = top; y < std::min(top + tile_height, picture.height); ++y) {
        for (std::uint32_t x = left; x < std::min(left + tile_width, picture.width); ++x)
          pixels.emplace_back(x, y);
      }
    }
  }
  return pixels;
}

TEST(PixelWalk, VisitsEveryPixelInOrderFromWhereverItBegins) {
  for (const auto& size : Pixels{{1, 1}, {3, 2}, {8, 8}, {21, 10}, {17, 33}, {64, 1}, {1, 64}}) {
    for (const bool tiled : {false, true}) {
      const Pinhole shape = picture(size.first, size.second, tiled);
      const Pixels pixels = expected(shape);
      for (std::size_t first = 0; first < pixels.size(); first += 5) {
        PixelWalk walk(shape, first);
        for (std::size_t i = first; i < pixels.size(); ++i, walk.next())
          ASSERT_EQ(std::pair(walk.x(), walk.y()), pixels[i]) << first << " " << i;
      }
    }
  }
}

TEST(PixelWalk, ReachesTheLastPixelOfTheLargestPicture) {
  const Pinhole largest = picture(kMaxSide, kMaxSide, true);
  const PixelWalk walk(largest, std::uint64_t{kMaxSide} * kMaxSide - 1);
  EXPECT_EQ(walk.x(), kMaxSide - 1);
  EXPECT_EQ(walk.y(), kMaxSide - 1);
}

}  // namespace
}  // namespace sightline::proto::rays
