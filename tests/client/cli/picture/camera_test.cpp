// The overview and user-defined cameras.
#include "client/cli/picture/camera.h"

#include <gtest/gtest.h>

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

TEST(Camera, TheOverviewIsOnePointTwoDiagonalsFromTheCenter) {
  const auto camera = make_camera({}, scene_of({0, 0, 0, 2, 4, 4}));
  ASSERT_TRUE(camera);
  const double norm = std::sqrt(1 + 0.49 + 0.25);
  const double distance = 1.2 * 6;
  expect_near(camera->eye,
              {1 + distance / norm, 2 + 0.7 * distance / norm, 2 + 0.5 * distance / norm});
  expect_near(camera->forward, {-1 / norm, -0.7 / norm, -0.5 / norm});
  EXPECT_NEAR(camera->half_height, std::tan(20 * std::acos(-1.0) / 180), 1e-12);
}

TEST(Camera, UpIsTheScenesUpAxis) {
  EXPECT_GT(make_camera({}, scene_of({0, 0, 0, 1, 1, 1}, UpAxis::kZ))->up[2], 0.8);
  EXPECT_GT(make_camera({}, scene_of({0, 0, 0, 1, 1, 1}, UpAxis::kY))->up[1], 0.7);
  EXPECT_GT(make_camera({}, scene_of({0, 0, 0, 1, 1, 1}))->up[1], 0.7);
}

TEST(Camera, TheMiddleOfThePictureIsForwardAndItsTopIsUp) {
  const auto camera = make_camera({Vec3{0, 0, 5}, Vec3{0, 0, 0}, 90}, {});
  ASSERT_TRUE(camera);
  expect_near(camera->direction(0.75, 0.5, 1.5), {0, 0, -1});
  const double half = std::sqrt(0.5);
  expect_near(camera->direction(0.75, 0, 1.5), {0, half, -half});
  EXPECT_GT(camera->direction(1.5, 0.5, 1.5)[0], 0);
}

TEST(Camera, LookingAlongTheUpAxisGivesAPicture) {
  const auto camera = make_camera({Vec3{0, 5, 0}, Vec3{0, 0, 0}}, {});
  ASSERT_TRUE(camera);
  EXPECT_NEAR(length(camera->right), 1, 1e-12);
  EXPECT_NEAR(length(camera->up), 1, 1e-12);
  EXPECT_NEAR(dot(camera->up, camera->forward), 0, 1e-12);
}

TEST(Camera, AnEyeWithoutATargetLooksAtTheCenter) {
  const auto camera = make_camera({Vec3{1, 1, 9}, {}}, scene_of({0, 0, 0, 2, 2, 2}));
  ASSERT_TRUE(camera);
  expect_near(camera->forward, {0, 0, -1});
}

TEST(Camera, ScenesWithoutExtentHaveAnOverview) {
  EXPECT_TRUE(make_camera({}, SceneInfo{}));
  EXPECT_TRUE(make_camera({}, scene_of({3, 3, 3, 3, 3, 3})));
}

TEST(Camera, AnEyeAtItsTargetIsAnError) {
  EXPECT_FALSE(make_camera({Vec3{1, 2, 3}, Vec3{1, 2, 3}}, {}));
}

}  // namespace
}  // namespace sightline::client::cli::picture
