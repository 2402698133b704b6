// The arrays that a mesh accepts and refuses.
#include "scenegraph/model/mesh.h"

#include <gtest/gtest.h>

#include <limits>

namespace sightline::scenegraph::model {
namespace {

const std::vector<accel::geometry::Vec3f> kCorners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

TEST(Mesh, CountsVerticesAndFaces) {
  auto corners = kCorners;
  corners.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
  const auto mesh = Mesh::make(corners, {{0, 1, 2},
                                         {accel::geometry::kNoVertex, accel::geometry::kNoVertex,
                                          accel::geometry::kNoVertex},
                                         {0, 1, 3}});
  ASSERT_TRUE(mesh);
  EXPECT_EQ((*mesh)->faces(), 3u);
  EXPECT_EQ((*mesh)->triangles(), 2u);
  EXPECT_EQ((*mesh)->nonfinite(), 1u);
  EXPECT_EQ((*mesh)->bounds().hi.x, 1.0f);
  EXPECT_EQ((*mesh)->bytes(), 4 * 12 + 3 * 12u);
}

TEST(Mesh, NamesTheFaceAndTheIndexOutOfRange) {
  const auto mesh = Mesh::make(kCorners, {{0, 1, 2}, {0, 7, 2}});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, Code::kInvalidArgument);
  EXPECT_EQ(mesh.error().message, "face 1 has vertex index 7, but the mesh has 3 vertices");
  // Two of three indices are kNoVertex: this does not mark the face as missing.
  EXPECT_FALSE(Mesh::make(kCorners, {{accel::geometry::kNoVertex, accel::geometry::kNoVertex, 0}}));
}

TEST(Mesh, MayBeEmpty) {
  const auto mesh = Mesh::make({}, {});
  ASSERT_TRUE(mesh);
  EXPECT_TRUE((*mesh)->bounds().empty());
}

}  // namespace
}  // namespace sightline::scenegraph::model
