// The overview and user-defined cameras.
#include "client/cli/picture/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sightline::client::cli::picture {
namespace {

SceneInfo scene_of(std::array<double, 6> bounds, UpAxis up = UpAxis::kUnknown) {
  SceneInfo scene;
  scene.bounds = bounds;
  scene.up_axis = up;
  return scene;
}

void expect_near(const Vec3& a, const Vec3& b) {
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], 1e-12) << k;
}

constexpr PictureSize kWide{160, 90}, kTall{50, 200};

// How far a point is from the middle of the picture: 1 at its left and right, and at its top and
// bottom edges.
std::array<double, 2> position_of(const Camera& camera, const Vec3& point, PictureSize size) {
  const Vec3 seen = sub(point, camera.eye);
  const double depth = camera.orthographic ? 1 : dot(seen, camera.forward);
  const double aspect = static_cast<double>(size.width) / size.height;
  EXPECT_GT(dot(seen, camera.forward), 0) << "before the eye";
  return {std::abs(dot(seen, camera.right)) / (depth * camera.half_height * aspect),
          std::abs(dot(seen, camera.up)) / (depth * camera.half_height)};
}

// The largest place of a corner of the bounds.
double reach(const Camera& camera, const std::array<double, 6>& b, PictureSize size) {
  double most = 0;
  for (unsigned i = 0; i < 8; ++i) {
    const Vec3 corner{b[(i & 1U) != 0 ? 3 : 0], b[(i & 2U) != 0 ? 4 : 1], b[(i & 4U) != 0 ? 5 : 2]};
    const auto position = position_of(camera, corner, size);
    most = std::max({most, position[0], position[1]});
  }
  return most;
}

TEST(Camera, TheOverviewShowsTheWholeSceneWithAMargin) {
  const std::array<double, 6> scenes[] = {{0, 0, 0, 2, 4, 4},
                                          {-500, 0, -3, 500, 2, 3},
                                          {1e5, 1e5, 10, 1e5 + 1, 1e5 + 300, 11},
                                          {0, 0, 0, 100, 100, 0}};
  for (const auto& bounds : scenes) {
    for (const PictureSize size : {kWide, kTall}) {
      for (const bool orthographic : {false, true}) {
        for (const UpAxis up : {UpAxis::kY, UpAxis::kZ}) {
          CameraRequest request;
          request.orthographic = orthographic;
          const auto camera = make_camera(request, scene_of(bounds, up), size);
          ASSERT_TRUE(camera);
          EXPECT_NEAR(reach(*camera, bounds, size), 0.95, 1e-6);
        }
      }
    }
  }
}

TEST(Camera, ATurnedSceneHasTheSameOverview) {
  const auto y = make_camera({}, scene_of({1, 2, 3, 4, 6, 8}, UpAxis::kY), kWide);
  // (x, y, z) of the scene before is (x, -z, y) here.
  const auto z = make_camera({}, scene_of({1, -8, 2, 4, -3, 6}, UpAxis::kZ), kWide);
  ASSERT_TRUE(y && z);
  expect_near(z->eye, {y->eye[0], -y->eye[2], y->eye[1]});
  expect_near(z->right, {y->right[0], -y->right[2], y->right[1]});
}

TEST(Camera, UpMayBeGiven) {
  CameraRequest request;
  request.up = Vec3{0, 0, -2};
  const auto camera = make_camera(request, scene_of({0, 0, 0, 1, 1, 1}, UpAxis::kY), kWide);
  EXPECT_LT(camera->up[2], -0.7);
  const Axes axes = upright_axes({1, 2, -3});
  EXPECT_NEAR(dot(axes.up, axes.side), 0, 1e-12);
  expect_near(cross(axes.side, axes.up), axes.front);
}

TEST(Camera, ParallelRaysStartSideBySide) {
  CameraRequest request{Vec3{0, 0, 5}, Vec3{0, 0, 1}, 90};
  request.orthographic = true;
  const auto camera = make_camera(request, {}, kWide);
  ASSERT_TRUE(camera);
  const ViewRay corner = camera->ray(0, 0, 1.5);
  expect_near(corner.origin, {-6, 4, 5});
  expect_near(corner.direction, {0, 0, -1});
}

TEST(Camera, UpIsTheScenesUpAxis) {
  EXPECT_GT(make_camera({}, scene_of({0, 0, 0, 1, 1, 1}, UpAxis::kZ), kWide)->up[2], 0.8);
  EXPECT_GT(make_camera({}, scene_of({0, 0, 0, 1, 1, 1}, UpAxis::kY), kWide)->up[1], 0.7);
  EXPECT_GT(make_camera({}, scene_of({0, 0, 0, 1, 1, 1}), kWide)->up[1], 0.7);
}

TEST(Camera, TheMiddleOfThePictureIsForwardAndItsTopIsUp) {
  const auto camera = make_camera({Vec3{0, 0, 5}, Vec3{0, 0, 0}, 90}, {}, kWide);
  ASSERT_TRUE(camera);
  expect_near(camera->ray(0.75, 0.5, 1.5).direction, {0, 0, -1});
  const double half = std::sqrt(0.5);
  expect_near(camera->ray(0.75, 0, 1.5).direction, {0, half, -half});
  EXPECT_GT(camera->ray(1.5, 0.5, 1.5).direction[0], 0);
}

TEST(Camera, LookingAlongTheUpAxisGivesAPicture) {
  const auto camera = make_camera({Vec3{0, 5, 0}, Vec3{0, 0, 0}}, {}, kWide);
  ASSERT_TRUE(camera);
  EXPECT_NEAR(length(camera->right), 1, 1e-12);
  EXPECT_NEAR(length(camera->up), 1, 1e-12);
  EXPECT_NEAR(dot(camera->up, camera->forward), 0, 1e-12);
}

TEST(Camera, AnEyeWithoutATargetLooksAtTheCenter) {
  const auto camera = make_camera({Vec3{1, 1, 9}, {}}, scene_of({0, 0, 0, 2, 2, 2}), kWide);
  ASSERT_TRUE(camera);
  expect_near(camera->forward, {0, 0, -1});
}

TEST(Camera, ScenesWithoutExtentHaveAnOverview) {
  EXPECT_TRUE(make_camera({}, SceneInfo{}, kWide));
  EXPECT_TRUE(make_camera({}, scene_of({3, 3, 3, 3, 3, 3}), kWide));
}

TEST(Camera, AnEyeAtItsTargetIsAnError) {
  EXPECT_FALSE(make_camera({Vec3{1, 2, 3}, Vec3{1, 2, 3}}, {}, kWide));
}

}  // namespace
}  // namespace sightline::client::cli::picture
