// A picture of a scene by ray queries, and its PNG file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/cli/flags.h"
#include "client/cli/picture/camera.h"
#include "client/cli/picture/clearance.h"
#include "client/cli/picture/scale.h"
#include "client/client.h"
#include "client/result.h"

namespace sightline::client::cli::picture {

enum class PictureMode : std::uint8_t { kNormal, kLit, kDepth, kNode, kHeat, kClearance };

struct PictureRequest {
  PictureMode mode = PictureMode::kNormal;
  PictureSize size = kDefaultSize;
  CameraRequest camera;
  bool with_scale =
      true;  ///< beside kDepth, kHeat and kClearance, in a picture that is large enough
  Consistency consistency;
  ClearanceRequest clearance{};  ///< of kClearance
};

struct Picture {
  std::vector<std::uint8_t> rgb;  ///< sRGB, (height, width, 3)
  CastReport report;
  /// Set for kDepth, kHeat and kClearance, also where it is not drawn.
  std::optional<Scale> scale{};
  /// Of kClearance: the least and the greatest, as in Clearance.
  std::optional<ValueRange> distances{};
};

/// Whether a request has a camera: its eye is not the point that it looks at.
bool has_view(const PictureRequest& request, const SceneInfo& scene);

/// Casts kSamplesPerPixel rays per pixel; kLit casts as many again from what they hit, and
/// kClearance asks for the distance of what they hit. The scale takes its columns from the view.
/// Call it if has_view(). kHeat builds no trees and shows those
/// that exist; the other modes build as the server's policy says. `progress` is called with the
/// part that is done, 0 to 1, on the calling thread.
Result<Picture> render_picture(const Client& client, const SceneInfo& scene,
                               const PictureRequest& request,
                               const std::function<void(double)>& progress);

/// Encodes a picture as PNG. `rgb`: sRGB, 8 bits, (height, width, 3). Errors: kInternal, with
/// libpng's message.
Result<std::string> encode_png(std::span<const std::uint8_t> rgb, std::uint32_t width,
                               std::uint32_t height);

}  // namespace sightline::client::cli::picture
