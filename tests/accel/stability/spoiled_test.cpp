// A spoiled triangle changes no hit of the others.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "accel/published/any_builder.h"
#include "tests/accel/stability/asked_tree.h"
#include "tests/support/hard_rays.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// Every hit of `spoiled` must equal the hit in the mesh without its last face.
void expect_harmless(const TestMesh& mesh, const TestMesh& spoiled) {
  const std::vector<accel::geometry::Ray> rays = make_hard_rays(mesh, 10 * kHardRayKinds, 4);
  for (const std::string_view builder : accel::published::builder_names()) {
    AskedTree good(mesh, builder), full(spoiled, builder), growing(spoiled, builder);
    full.build();
    for (const accel::geometry::Ray& ray : rays) {
      const NearestHit expected = good.nearest(ray);
      ASSERT_EQ(full.nearest(ray), expected) << builder;
      ASSERT_EQ(growing.nearest(ray), expected) << builder;
    }
  }
}

TEST(SpoiledTriangle, WithANonfiniteVertex) {
  const TestMesh mesh = hills(400, 1);
  const std::array<float, 3> odd{kNan, kInf, -kInf};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    TestMesh spoiled = mesh;
    accel::geometry::Vec3f vertex{0.5f, 0.1f, 0.5f};
    vertex[axis] = odd[axis];
    spoiled.faces.push_back({3, 200, static_cast<std::uint32_t>(spoiled.vertices.size())});
    spoiled.vertices.push_back(vertex);
    expect_harmless(mesh, spoiled);
  }
}

TEST(SpoiledTriangle, WithoutAnArea) {
  const TestMesh mesh = hills(400, 1);
  const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const accel::geometry::Face& face :
       {accel::geometry::Face{5, 5, 5}, {5, 6, 5}, {n, n + 1, n + 2}}) {
    TestMesh spoiled = mesh;
    // Three points in a line through the whole box, above the hills.
    for (const float t : {0.0f, 0.5f, 1.0f}) spoiled.vertices.push_back({t, 0.5f, t});
    spoiled.faces.push_back(face);
    expect_harmless(mesh, spoiled);
  }
}

TEST(SpoiledTriangle, AllOfThem) {
  TestMesh mesh = hills(100, 1);
  for (accel::geometry::Vec3f& vertex : mesh.vertices) vertex.y = kNan;
  for (const std::string_view builder : accel::published::builder_names()) {
    AskedTree full(mesh, builder), growing(mesh, builder);
    full.build();
    for (const accel::geometry::Ray& ray :
         {accel::geometry::Ray{{0, 0, 0}, {1, 0, 0}}, {{0.5, 3, 0.5}, {0, -1, 0}}}) {
      EXPECT_EQ(full.nearest(ray), NearestHit{}) << builder;
      EXPECT_EQ(growing.nearest(ray), NearestHit{}) << builder;
    }
  }
}

}  // namespace
}  // namespace sightline::tests
