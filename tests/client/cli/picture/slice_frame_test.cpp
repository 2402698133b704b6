// Where slices lie, and the points of their pixels.
#include "client/cli/picture/slice_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "client/points.h"

namespace sightline::client::cli::picture {
namespace {

SceneInfo scene_of(UpAxis up) {
  SceneInfo scene;
  scene.up_axis = up;
  scene.bounds = {{0, 10, 100, 8, 14, 102}};
  return scene;
}

TEST(SliceFrame, ShowsTheWholeSceneInSquarePixels) {
  for (const PictureSize size : {PictureSize{100, 100}, PictureSize{300, 20}, PictureSize{7, 90}}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const UpAxis up : {UpAxis::kUnknown, UpAxis::kY, UpAxis::kZ}) {
        const SceneInfo scene = scene_of(up);
        const SliceFrame frame = frame_on({axis, 3.5}, scene, size);
        EXPECT_TRUE(has_area(frame));
        EXPECT_DOUBLE_EQ(length(frame.across) / size.width, length(frame.down) / size.height);
        EXPECT_EQ(frame.origin[axis], 3.5);
        for (std::size_t k = 0; k < 3; ++k) {
          if (k == axis) continue;
          const double end = frame.origin[k] + frame.across[k] + frame.down[k];
          EXPECT_LT(std::min(frame.origin[k], end), (*scene.bounds)[k]);
          EXPECT_GT(std::max(frame.origin[k], end), (*scene.bounds)[k + 3]);
        }
      }
    }
  }
}

TEST(SliceFrame, UpIsUpAndLevelPlanesAreSeenFromAbove) {
  const auto signs = [](std::size_t axis, UpAxis up) {
    const SliceFrame frame = frame_on({axis, 0}, scene_of(up), {10, 10});
    std::string text;
    for (const Vec3& edge : {frame.across, frame.down}) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (edge[k] != 0) text += std::string(edge[k] > 0 ? "+" : "-") + static_cast<char>('x' + k);
      }
    }
    return text;
  };
  EXPECT_EQ(signs(0, UpAxis::kZ), "+y-z");
  EXPECT_EQ(signs(1, UpAxis::kZ), "+x-z");
  EXPECT_EQ(signs(2, UpAxis::kZ), "+x-y");
  EXPECT_EQ(signs(0, UpAxis::kY), "+z-y");
  EXPECT_EQ(signs(1, UpAxis::kY), "+x+z");
  EXPECT_EQ(signs(2, UpAxis::kY), "+x-y");
  EXPECT_EQ(signs(2, UpAxis::kUnknown), "+x-y");
}

TEST(SliceFrame, AnEmptySceneHasASquare) {
  const SliceFrame frame = frame_on({2, 7}, {}, {50, 50});
  EXPECT_TRUE(has_area(frame));
  EXPECT_EQ(frame.origin[2], 7);
}

TEST(SliceFrame, PixelsAreMeasuredInTheirMiddle) {
  const SliceFrame frame{{0, 0, 5}, {4, 0, 0}, {0, -2, 0}};
  const auto points = make_points(pixels_of(frame, {4, 2}));
  ASSERT_TRUE(points);
  ASSERT_EQ(points->size(), 3U * 8);
  EXPECT_EQ((Vec3{(*points)[0], (*points)[1], (*points)[2]}), (Vec3{0.5, -0.5, 5}));
  EXPECT_EQ((Vec3{(*points)[21], (*points)[22], (*points)[23]}), (Vec3{3.5, -1.5, 5}));
}

TEST(SliceFrame, EdgesThatAreParallelHaveNoArea) {
  EXPECT_TRUE(has_area({{}, {1, 0, 0}, {1, 1, 0}}));
  EXPECT_FALSE(has_area({{}, {1, 0, 0}, {-2, 0, 0}}));
  EXPECT_FALSE(has_area({{}, {1, 0, 0}, {0, 0, 0}}));
}

}  // namespace
}  // namespace sightline::client::cli::picture
