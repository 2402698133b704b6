// A picture of a scene, by ray queries.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/cli/arguments.h"
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

/// Casts kSamplesPerPixel rays a pixel. kHeat grows no trees and shows those there are; the other
/// modes grow them as the server's policy says. `progress` is told the part that is done, 0 to 1,
/// on the calling thread.
Result<Picture> take_picture(const Client& client, const std::string& scene,
                             const PictureRequest& request,
                             const std::function<void(double)>& progress);

}  // namespace sightline::client::cli::picture
