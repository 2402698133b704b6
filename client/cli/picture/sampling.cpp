// Tiles, left to right and top to bottom.
#include "client/cli/picture/sampling.h"

#include <algorithm>

namespace sightline::client::cli::picture {

std::vector<Pixel> tiled_pixels(PictureSize size) {
  constexpr std::uint32_t kTile = 8;
  std::vector<Pixel> pixels;
  pixels.reserve(std::size_t{size.width} * size.height);
  for (std::uint32_t top = 0; top < size.height; top += kTile) {
    for (std::uint32_t left = 0; left < size.width; left += kTile) {
      for (std::uint32_t y = top; y < std::min(top + kTile, size.height); ++y) {
        for (std::uint32_t x = left; x < std::min(left + kTile, size.width); ++x) {
          pixels.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
        }
      }
    }
  }
  return pixels;
}

}  // namespace sightline::client::cli::picture
