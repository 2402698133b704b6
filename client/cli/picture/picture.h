// A picture of a scene by ray queries, and its PNG file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "client/cli/flags.h"
#include "client/cli/picture/camera.h"
#include "client/client.h"
#include "client/result.h"

namespace sightline::client::cli::picture {

enum class PictureMode : std::uint8_t { kNormal, kDepth, kNode, kHeat };

struct PictureRequest {
  PictureMode mode = PictureMode::kNormal;
  PictureSize size{1280, 720};
  Camera camera;
  UpAxis up_axis = UpAxis::kUnknown;
  Consistency consistency;
};

struct Picture {
  std::vector<std::uint8_t> rgb;  ///< sRGB, (height, width, 3)
  CastReport report;
};

/// Casts kSamplesPerPixel rays per pixel. kHeat builds no trees and shows those that exist; the
/// other modes build as the server's policy says. `progress` is called with the part that is done,
/// 0 to 1, on the calling thread.
Result<Picture> render_picture(const Client& client, const std::string& scene,
                               const PictureRequest& request,
                               const std::function<void(double)>& progress);

inline constexpr std::size_t kSamplesPerPixel = 4;

/// Positions within a pixel: a rotated 2x2 grid, so that edges that are nearly horizontal or
/// vertical get four shades.
inline constexpr std::array<std::array<double, 2>, kSamplesPerPixel> kSampleOffsets{
    {{0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}}};

struct Pixel {
  std::uint16_t x, y;
};

/// Every pixel once, in 8x8 tiles, so that consecutive rays enter the same parts of a scene.
std::vector<Pixel> tiled_pixels(PictureSize size);

/// Encodes a picture as PNG. `rgb`: sRGB, 8 bits, (height, width, 3). Errors: kInternal, with
/// libpng's message.
Result<std::string> encode_png(std::span<const std::uint8_t> rgb, std::uint32_t width,
                               std::uint32_t height);

}  // namespace sightline::client::cli::picture
