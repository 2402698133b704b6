// Where in a picture rays are cast, and in which order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/cli/arguments.h"

namespace sightline::client::cli::picture {

inline constexpr std::size_t kSamplesPerPixel = 4;

/// Places within a pixel: a 2x2 grid, turned so that near-horizontal and near-vertical edges get
/// four shades.
inline constexpr std::array<std::array<double, 2>, kSamplesPerPixel> kSampleOffsets{
    {{0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}}};

struct Pixel {
  std::uint16_t x, y;
};

/// Every pixel once, in 8x8 tiles: rays that follow one another then enter the same parts of a
/// scene.
std::vector<Pixel> tiled_pixels(PictureSize size);

}  // namespace sightline::client::cli::picture
