// The default camera shows an overview of the scene.
#include "client/cli/picture/camera.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>

namespace sightline::client::cli::picture {
namespace {

constexpr Axes kSceneAxes{};
constexpr Vec3 kOverviewFrom{1, 0.7, 0.5};  // along side, up and front of the scene
constexpr double kMargin = 0.05;            // share of the picture's half, on each side
constexpr double kNearlyParallel = 1e-6;    // sine of the angle between two directions

Vec3 up_of(UpAxis axis) { return axis == UpAxis::kZ ? Vec3{0, 0, 1} : Vec3{0, 1, 0}; }

bool are_parallel(const Vec3& a, const Vec3& b) { return length(cross(a, b)) < kNearlyParallel; }

// A point's coordinates along an axis of the picture and along the view.
struct Seen {
  double across, along;
};

// How far points reach along one axis of the picture.
class Extent {
 public:
  // `slope`: across over along, at the edge of the picture.
  explicit Extent(double slope) : slope_(slope) {}

  void add(const Seen& point) {
    low_ = std::min(low_, point.across);
    high_ = std::max(high_, point.across);
    left_ = std::max(left_, -point.across - slope_ * point.along);
    right_ = std::max(right_, point.across - slope_ * point.along);
  }

  // The farthest eye that sees all points: |across - eye| <= slope (along - eye) for each.
  double farthest_eye() const { return -(left_ + right_) / (2 * slope_); }
  double middle_in_perspective() const { return (right_ - left_) / 2; }
  double middle() const { return (low_ + high_) / 2; }
  double half() const { return (high_ - low_) / 2; }

 private:
  static constexpr double kFar = std::numeric_limits<double>::infinity();

  double slope_;
  double low_ = kFar, high_ = -kFar, left_ = -kFar, right_ = -kFar;
};

struct Box {
  Vec3 low{-0.5, -0.5, -0.5}, high{0.5, 0.5, 0.5};

  Vec3 center() const { return scale(add(low, high), 0.5); }
  Vec3 corner(unsigned i) const {
    return {(i & 1U) == 0 ? low[0] : high[0], (i & 2U) == 0 ? low[1] : high[1],
            (i & 4U) == 0 ? low[2] : high[2]};
  }
};

// A scene that is a point, or empty, has a box around it.
Box box_of(const SceneInfo& scene) {
  Box box;
  if (!scene.bounds) return box;
  const auto& b = *scene.bounds;
  const Vec3 low{b[0], b[1], b[2]}, high{b[3], b[4], b[5]};
  if (low == high) return {add(low, box.low), add(low, box.high)};
  return {low, high};
}

void look_along(Camera& camera, const Vec3& direction) {
  camera.forward = unit(direction);
  Vec3 up = camera.scene.up;
  if (are_parallel(camera.forward, up)) up = camera.scene.front;
  camera.right = unit(cross(camera.forward, up));
  camera.up = cross(camera.right, camera.forward);
}

// Moves the eye back, and to where the box is in the middle of the picture.
void show_whole(Camera& camera, const Box& box, double aspect) {
  const double slope = camera.half_height * (1 - kMargin);
  Extent x(slope * aspect), y(slope);
  double nearest = std::numeric_limits<double>::infinity();
  const Vec3 center = box.center();
  for (unsigned i = 0; i < 8; ++i) {
    const Vec3 corner = sub(box.corner(i), center);
    const double along = dot(corner, camera.forward);
    x.add({dot(corner, camera.right), along});
    y.add({dot(corner, camera.up), along});
    nearest = std::min(nearest, along);
  }
  Vec3 eye{x.middle_in_perspective(), y.middle_in_perspective(),
           std::min(x.farthest_eye(), y.farthest_eye())};
  if (camera.orthographic) {
    camera.half_height = std::max(x.half() / aspect, y.half()) / (1 - kMargin);
    eye = {x.middle(), y.middle(), nearest - camera.half_height};
  }
  camera.eye = add(add(center, scale(camera.forward, eye[2])),
                   add(scale(camera.right, eye[0]), scale(camera.up, eye[1])));
}

}  // namespace

Axes upright_axes(const Vec3& up) {
  Axes axes;
  axes.up = unit(up);
  const Vec3 side = are_parallel(kSceneAxes.side, axes.up) ? kSceneAxes.front : kSceneAxes.side;
  axes.side = unit(sub(side, scale(axes.up, dot(side, axes.up))));
  axes.front = cross(axes.side, axes.up);
  return axes;
}

ViewRay Camera::ray(double x, double y, double aspect) const {
  const Vec3 sideways = scale(right, (2 * x - aspect) * half_height);
  const Vec3 upward = scale(up, (1 - 2 * y) * half_height);
  if (orthographic) return {add(eye, add(sideways, upward)), forward};
  return {eye, unit(add(forward, add(sideways, upward)))};
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

std::optional<Camera> make_camera(const CameraRequest& request, const SceneInfo& scene,
                                  PictureSize size) {
  const Box box = box_of(scene);
  Camera camera;
  camera.scene = upright_axes(request.up.value_or(up_of(scene.up_axis)));
  camera.orthographic = request.orthographic;
  camera.half_height = std::tan(request.fov * std::numbers::pi / 360);
  const Vec3 at = request.at.value_or(box.center());
  if (!request.eye) {
    const Axes& axes = camera.scene;
    look_along(camera,
               add(scale(axes.side, -kOverviewFrom[0]),
                   add(scale(axes.up, -kOverviewFrom[1]), scale(axes.front, -kOverviewFrom[2]))));
    show_whole(camera, box, static_cast<double>(size.width) / size.height);
    // The view stays the same, of another point.
    if (request.at) camera.eye = add(camera.eye, sub(at, box.center()));
    return camera;
  }
  camera.eye = *request.eye;
  const Vec3 view = sub(at, camera.eye);
  if (!(length(view) > 0)) return {};
  look_along(camera, view);
  if (camera.orthographic) camera.half_height *= length(view);
  return camera;
}

}  // namespace sightline::client::cli::picture
