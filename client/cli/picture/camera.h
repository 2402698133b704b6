// A pinhole camera: where a picture's rays start and go.
#pragma once

#include <optional>

#include "client/cli/picture/vec3.h"
#include "client/scene_info.h"

namespace sightline::client::cli::picture {

struct Camera {
  Vec3 eye{};
  Vec3 forward{0, 0, -1};  ///< Unit, as the next two; the three are at right angles.
  Vec3 right{1, 0, 0};
  Vec3 up{0, 1, 0};
  double half_height = 1;  ///< Of the picture, at distance 1.

  /// The unit direction through a place in the picture: x from 0 at the left to `aspect`, y from 0
  /// at the top to 1.
  Vec3 direction(double x, double y, double aspect) const;
};

inline constexpr double kDefaultFov = 40;  ///< Degrees, from the bottom of the picture to its top.

/// What of a camera is asked for; the rest is the overview: center + 1.2 diagonals (1, 0.7,
/// 0.5)/|.|, looking at the center of the scene, up as the scene records it, or y.
struct CameraRequest {
  std::optional<Vec3> eye;
  std::optional<Vec3> at;
  double fov = kDefaultFov;  ///< Degrees, between 0 and 180.
};

/// Nothing if the eye is where it looks at.
std::optional<Camera> make_camera(const CameraRequest& request, const SceneInfo& scene);

}  // namespace sightline::client::cli::picture
