// The pixels of a picture while it is painted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/cli/picture/camera.h"
#include "client/cli/picture/shading.h"

namespace sightline::client::cli::picture {

struct Pixel {
  std::uint16_t x, y;
};

/// Every pixel once, in the order of the rays of a picture.
std::vector<Pixel> tiled_pixels(PictureSize size);

/// Sums up the colours of the samples of each pixel. Sample s of the k-th pixel in tile order has
/// the number k * kSamplesPerPixel + s.
class Film {
 public:
  Film(PictureSize size, const Camera& camera);

  const Camera& camera() const { return camera_; }
  PictureSize size() const { return size_; }
  std::size_t samples() const { return pixels_.size() * kSamplesPerPixel; }
  /// 0 at the top of the picture, 1 at the bottom.
  double height_of(std::size_t sample) const;
  ViewRay ray(std::size_t sample) const;

  void expose(std::size_t sample, const Rgb& colour);
  /// sRGB, (height, width, 3).
  std::vector<std::uint8_t> develop() const;

 private:
  PictureSize size_;
  Camera camera_;
  std::vector<Pixel> pixels_;
  std::vector<Rgb> sums_;
};

}  // namespace sightline::client::cli::picture
