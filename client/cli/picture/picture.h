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
  PictureSize size = kDefaultSize;
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

struct Pixel {
  std::uint16_t x, y;
};

/// Every pixel once, in the order of the rays of a picture.
std::vector<Pixel> tiled_pixels(PictureSize size);

/// Encodes a picture as PNG. `rgb`: sRGB, 8 bits, (height, width, 3). Errors: kInternal, with
/// libpng's message.
Result<std::string> encode_png(std::span<const std::uint8_t> rgb, std::uint32_t width,
                               std::uint32_t height);

}  // namespace sightline::client::cli::picture
