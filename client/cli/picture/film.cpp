// The pixels of a picture while it is painted.
#include "client/cli/picture/film.h"

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

Film::Film(PictureSize size, const Camera& camera)
    : size_(size), camera_(camera), pixels_(tiled_pixels(size)), sums_(pixels_.size(), Rgb{}) {}

double Film::height_of(std::size_t sample) const {
  const auto [x, y] = pixels_[sample / kSamplesPerPixel];
  return (y + kSampleOffsets[sample % kSamplesPerPixel][1]) / size_.height;
}

ViewRay Film::ray(std::size_t sample) const {
  const auto [x, y] = pixels_[sample / kSamplesPerPixel];
  const double across = (x + kSampleOffsets[sample % kSamplesPerPixel][0]) / size_.height;
  const double aspect = static_cast<double>(size_.width) / size_.height;
  return camera_.ray(across, height_of(sample), aspect);
}

void Film::expose(std::size_t sample, const Rgb& colour) {
  Rgb& sum = sums_[sample / kSamplesPerPixel];
  for (std::size_t c = 0; c < 3; ++c) sum[c] += colour[c] / float{kSamplesPerPixel};
}

std::vector<std::uint8_t> Film::develop() const {
  std::vector<std::uint8_t> rgb(3 * pixels_.size());
  for (std::size_t k = 0; k < pixels_.size(); ++k) {
    const std::size_t index = std::size_t{pixels_[k].y} * size_.width + pixels_[k].x;
    for (std::size_t c = 0; c < 3; ++c) rgb[3 * index + c] = encode_srgb(sums_[k][c]);
  }
  return rgb;
}

}  // namespace sightline::client::cli::picture
