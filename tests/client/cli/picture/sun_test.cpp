// A picture with shadows, of scenes on a server.
#include "client/cli/picture/sun.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "client/cli/picture/picture.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"

namespace sightline::client::cli::picture {
namespace {

using SunPicture = tests::LiveClient;
using tests::kScene;

// Squares in planes z = 0, 1, ..., of which the upper ones are small.
importer::ImportedScene ground_under_a_roof(bool with_roof) {
  importer::ImportedScene scene = tests::row_of_sheets(with_roof ? 2 : 1);
  scene.up_axis = UpAxis::kZ;
  scene.meshes[0] = tests::sheets(1);
  scene.nodes[1].parent_from_local = {10, 0, 0, -5, 0, 10, 0, -5, 0, 0, 1, 0};
  if (with_roof) scene.nodes[2].parent_from_local = {4, 0, 0, -2, 0, 4, 0, -2, 0, 0, 1, 1.5};
  return scene;
}

std::size_t dark_pixels(const std::vector<std::uint8_t>& rgb) {
  std::size_t dark = 0;
  for (std::size_t i = 0; i < rgb.size(); i += 3) dark += rgb[i] < 150 ? 1 : 0;
  return dark;
}

TEST_F(SunPicture, ARoofCastsAShadowOnTheGround) {
  PictureRequest request;
  request.mode = PictureMode::kLit;
  request.size = {64, 64};
  std::size_t dark[2];
  for (const bool with_roof : {false, true}) {
    ASSERT_TRUE(upload_scene(client_, kScene, ground_under_a_roof(with_roof), {.replace = true}));
    const auto picture =
        render_picture(client_, *client_.get_scene(kScene), request, [](double) {});
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_GT(picture->report.rays, 64U * 64 * kSamplesPerPixel) << "rays to the sun are counted";
    dark[with_roof ? 1 : 0] = dark_pixels(picture->rgb);
  }
  EXPECT_EQ(dark[0], 0U) << "no surface is in the shadow of itself";
  EXPECT_GT(dark[1], 50U);
}

TEST_F(SunPicture, ParallelAndPerspectiveViewsSeeTheScene) {
  ASSERT_TRUE(upload_scene(client_, kScene, ground_under_a_roof(true), {}));
  for (const PictureMode mode : {PictureMode::kNormal, PictureMode::kLit, PictureMode::kDepth}) {
    for (const bool orthographic : {false, true}) {
      PictureRequest request;
      request.mode = mode;
      request.size = {48, 32};
      request.camera.orthographic = orthographic;
      const auto picture =
          render_picture(client_, *client_.get_scene(kScene), request, [](double) {});
      ASSERT_TRUE(picture) << picture.error().message;
      EXPECT_GT(picture->report.hits, picture->report.rays / 5);
    }
  }
}

TEST(Sun, StandsAboveAndIsAUnitVector) {
  Camera camera;
  for (const Vec3 forward : {Vec3{0, 0, -1}, Vec3{1, 0, 0}, Vec3{0, -1, 0}}) {
    camera.forward = forward;
    camera.up = forward[1] == 0 ? Vec3{0, 1, 0} : Vec3{0, 0, -1};
    const Vec3 sun = direction_to_sun(camera);
    EXPECT_NEAR(length(sun), 1, 1e-12);
    EXPECT_GT(sun[1], 0.6);
  }
}

}  // namespace
}  // namespace sightline::client::cli::picture
