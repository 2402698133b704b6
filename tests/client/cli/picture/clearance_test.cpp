// Pictures of clearances over a real connection, whose distances are known by formula.
#include "client/cli/picture/clearance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "client/cli/picture/picture.h"
#include "client/scene_upload.h"
#include "tests/client/support/boxes.h"
#include "tests/client/support/live_client.h"

namespace sightline::client::cli::picture {
namespace {

using tests::kScene;

constexpr std::uint32_t kSide = 64;  // pixels
constexpr std::uint64_t kSlab = 1, kPost = 2;
constexpr double kHeight = 8;  // of the camera above the slab

// A slab with its top at z = 1, and a post that floats 1 above it, from x = 3 to 4. The camera
// looks down at (4, 4), with the scene's y up, and sees no end of the slab.
class ClearancePicture : public tests::LiveClient {
 protected:
  void upload(bool with_post) {
    std::vector meshes{tests::mesh_of({{0, 0, 0}, {8, 8, 1}})};
    if (with_post) meshes.push_back(tests::mesh_of({{3, 0, 2}, {4, 8, 3}}));
    ASSERT_TRUE(upload_scene(client_, kScene, tests::scene_of(meshes), {.replace = true}));
  }

  Result<Picture> render(const ClearanceRequest& clearance) {
    PictureRequest request;
    request.mode = PictureMode::kClearance;
    request.size = {kSide, kSide};
    request.camera = {.eye = Vec3{4, 4, 1 + kHeight}, .at = Vec3{4, 4, 0}, .up = Vec3{0, 1, 0}};
    request.clearance = clearance;
    return render_picture(client_, *client_.get_scene(kScene), request, [](double) {});
  }
};

// Of a place in the picture, in pixels: where it is on the slab, and how far that is from the post.
double x_of(double column) {
  const double half = kHeight * std::tan(kDefaultFov / 2 * std::numbers::pi / 180);
  return 4 + half * (2 * column / kSide - 1);
}
double distance_of(double column) {
  const double x = x_of(column);
  return std::hypot(std::max({3 - x, x - 4, 0.0}), 1);
}

int channel(const Picture& picture, std::uint32_t x, std::uint32_t y, std::size_t k) {
  return picture.rgb[3 * (std::size_t{y} * kSide + x) + k];
}

TEST_F(ClearancePicture, DistancesAreThoseFromThePost) {
  upload(true);
  const auto picture = render({.node = kSlab});
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_EQ(picture->report.rays, std::uint64_t{kSide} * kSide * kSamplesPerPixel);
  EXPECT_EQ(picture->report.hits, picture->report.rays) << "the post does not hide the slab";
  ASSERT_TRUE(picture->distances);
  EXPECT_NEAR(picture->distances->low, 1, 1e-12);
  EXPECT_NEAR(picture->distances->high, distance_of(kSide - 0.125), 1e-12);
  EXPECT_EQ(picture->scale->range.low, 0);
  EXPECT_EQ(picture->scale->range.high, picture->distances->high);
  EXPECT_EQ(picture->scale->title, "clearance");
  EXPECT_TRUE(picture->scale->notes.empty());
}

TEST_F(ClearancePicture, ColoursTellTheDistance) {
  upload(true);
  constexpr double kRange = 2.5;
  const auto picture = render({.node = kSlab, .range = kRange});
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_EQ(picture->scale->range.high, kRange);
  const Camera above{.forward = {0, 0, -1}, .right = {1, 0, 0}, .up = {0, 1, 0}};
  const auto light = static_cast<float>(light_on({0, 0, 1}, above));
  for (std::uint32_t x = 0; x < kSide; ++x) {
    const auto distance = static_cast<float>(distance_of(x + 0.5));
    const Rgb expected = clearance_shade({distance, light}, {0, kRange});
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_LE(std::abs(channel(*picture, x, 30, k) - encode_srgb(expected[k])), 4) << x;
  }
}

TEST_F(ClearancePicture, WhatIsAloneIsGrey) {
  upload(false);
  const auto picture = render({.node = kSlab});
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_GT(picture->report.hits, 0U);
  EXPECT_FALSE(picture->distances);
  EXPECT_FALSE(picture->scale->notes.empty()) << "the scale tells what grey is";
  EXPECT_LE(std::abs(channel(*picture, 9, 9, 0) - channel(*picture, 9, 9, 2)), 2);
}

TEST_F(ClearancePicture, TheRestIsDrawnIfItIsAskedFor) {
  upload(true);
  const auto bare = render({.node = kPost});
  const auto both = render({.node = kPost, .with_context = true});
  ASSERT_TRUE(bare && both);
  EXPECT_EQ(bare->report.hits, both->report.hits);
  EXPECT_LT(bare->report.hits, bare->report.rays);
  EXPECT_NEAR(both->distances->low, 2, 1e-12) << "its upper face is seen, 2 above the slab";
  const std::uint32_t on_post = kSide / 2 - 3, beside = kSide - 4;
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_EQ(channel(*bare, on_post, 30, k), channel(*both, on_post, 30, k));
  EXPECT_LT(channel(*both, beside, 30, 0), channel(*bare, beside, 30, 0) - 10);
  EXPECT_LE(std::abs(channel(*both, beside, 30, 0) - channel(*both, beside, 30, 2)), 8) << "grey";
}

TEST_F(ClearancePicture, ANodeThatIsNotInViewHasNoDistances) {
  importer::ImportedScene scene = tests::scene_of(
      {tests::mesh_of({{0, 0, 0}, {8, 8, 1}}), tests::mesh_of({{100, 0, 2}, {101, 8, 3}})});
  ASSERT_TRUE(upload_scene(client_, kScene, scene, {}));
  const auto picture = render({.node = kPost});
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_EQ(picture->report.hits, 0U);
  EXPECT_FALSE(picture->distances);
  EXPECT_TRUE(picture->scale->notes.empty());
}

TEST_F(ClearancePicture, ANodeThatIsNotThereIsAnError) {
  upload(true);
  const auto picture = render({.node = 99});
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().code, Code::kNotFound);
}

}  // namespace
}  // namespace sightline::client::cli::picture
