// A pinhole camera: where the rays of a picture start and go.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "client/cli/flags.h"
#include "client/ray_generator.h"
#include "client/scene_info.h"

namespace sightline::client::cli::picture {

using Vec3 = std::array<double, 3>;

inline Vec3 add(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec3 sub(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec3 scale(const Vec3& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 unit(const Vec3& a) { return scale(a, 1 / length(a)); }
/// Interpolates linearly: a at s = 0, b at s = 1.
inline Vec3 mix(const Vec3& a, const Vec3& b, double s) {
  return add(scale(a, 1 - s), scale(b, s));
}

/// Three orthogonal unit vectors.
struct Axes {
  Vec3 side{1, 0, 0}, up{0, 1, 0}, front{0, 0, 1};
};

/// The axes with this `up`, which is not zero. For y these are the axes x, y, z, for z they are x,
/// z, -y: a scene that is turned from one to the other has the same place in them.
Axes upright_axes(const Vec3& up);

struct ViewRay {
  Vec3 origin{};
  Vec3 direction{};  ///< a unit vector
};

struct Camera {
  Vec3 eye{};
  Vec3 forward{0, 0, -1};  ///< a unit vector, like the next two; all three are orthogonal
  Vec3 right{1, 0, 0};
  Vec3 up{0, 1, 0};
  bool orthographic = false;
  /// Half the height of the picture plane: at distance 1, or of all rays if the camera is
  /// orthographic.
  double half_height = 1;
  Axes scene{};  ///< how the scene stands

  /// The ray through a point of the picture. x runs from 0 at the left to `aspect`, y from 0 at the
  /// top to 1.
  ViewRay ray(double x, double y, double aspect) const;
};

inline constexpr PictureSize kDefaultSize{1280, 720};
inline constexpr std::size_t kSamplesPerPixel = 4;

/// Positions within a pixel: a rotated 2x2 grid, so that edges that are nearly horizontal or
/// vertical get four shades.
inline constexpr std::array<std::array<double, 2>, kSamplesPerPixel> kSampleOffsets{
    {{0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}}};

/// The rays of a picture of this size: kSamplesPerPixel for each pixel, tile by tile. The camera is
/// not orthographic.
RayGenerator rays_of(const Camera& camera, PictureSize size);

inline constexpr double kDefaultFov = 40;  ///< degrees, from the bottom of the picture to its top

/// The parts of a camera that the user gives. The rest comes from the overview: it sees the bounds
/// of the scene whole, with a margin, from above and from a side.
struct CameraRequest {
  std::optional<Vec3> eye;
  std::optional<Vec3> at;
  double fov = kDefaultFov;  ///< degrees, between 0 and 180
  std::optional<Vec3> up{};  ///< not zero; otherwise the axis that the scene records, or y
  /// Parallel rays. With an eye, the picture is as high as `fov` shows it at the distance of `at`.
  bool orthographic = false;
};

/// Returns nothing if the eye is the point that it looks at.
std::optional<Camera> make_camera(const CameraRequest& request, const SceneInfo& scene,
                                  PictureSize size);

}  // namespace sightline::client::cli::picture
