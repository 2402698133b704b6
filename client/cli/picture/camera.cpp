// The default camera shows an overview of the scene.
#include "client/cli/picture/camera.h"

#include <numbers>
#include <utility>

namespace sightline::client::cli::picture {
namespace {

constexpr Vec3 kOverviewFrom{1, 0.7, 0.5};
constexpr double kOverviewDistance = 1.2;  // in diagonals of the scene
constexpr double kNearlyParallel = 1e-6;   // sine of the angle between the view and the up axis

Vec3 up_of(UpAxis axis) { return axis == UpAxis::kZ ? Vec3{0, 0, 1} : Vec3{0, 1, 0}; }

}  // namespace

Vec3 Camera::direction(double x, double y, double aspect) const {
  const Vec3 sideways = scale(right, (2 * x - aspect) * half_height);
  const Vec3 upward = scale(up, (1 - 2 * y) * half_height);
  return unit(add(forward, add(sideways, upward)));
}

RayGenerator rays_of(const Camera& camera, PictureSize size) {
  const double half_width = camera.half_height * size.width / size.height;
  Pinhole pinhole;
  pinhole.eye = camera.eye;
  pinhole.corner = add(camera.forward,
                       sub(scale(camera.up, camera.half_height), scale(camera.right, half_width)));
  pinhole.across = scale(camera.right, 2 * half_width);
  pinhole.down = scale(camera.up, -2 * camera.half_height);
  pinhole.width = size.width;
  pinhole.height = size.height;
  pinhole.samples.assign(kSampleOffsets.begin(), kSampleOffsets.end());
  pinhole.tiled = true;
  return {.rays = std::move(pinhole)};
}

std::optional<Camera> make_camera(const CameraRequest& request, const SceneInfo& scene) {
  Vec3 center{};
  double diagonal = 1;
  if (scene.bounds) {
    const auto& b = *scene.bounds;
    const Vec3 low{b[0], b[1], b[2]};
    const Vec3 high{b[3], b[4], b[5]};
    center = scale(add(low, high), 0.5);
    if (low != high) diagonal = length(sub(high, low));
  }
  Camera camera;
  const Vec3 at = request.at.value_or(center);
  camera.eye =
      request.eye.value_or(add(at, scale(unit(kOverviewFrom), kOverviewDistance * diagonal)));
  const Vec3 view = sub(at, camera.eye);
  if (!(length(view) > 0)) return {};
  camera.forward = unit(view);
  Vec3 up = up_of(scene.up_axis);
  if (length(cross(camera.forward, up)) < kNearlyParallel) up = {up[2], up[0], up[1]};
  camera.right = unit(cross(camera.forward, up));
  camera.up = cross(camera.right, camera.forward);
  camera.half_height = std::tan(request.fov * std::numbers::pi / 360);
  return camera;
}

}  // namespace sightline::client::cli::picture
