// Boxes of faces: four at a time equals one by one, on every SIMD target.
#include "accel/mesh/face_boxes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/accel/simd_targets.h"
#include "tests/support/random.h"

namespace sightline::accel::mesh {
namespace {

/// Coordinates that are equal, adjacent, denormal, huge, signed zeros, or not finite.
std::vector<geometry::Vec3f> odd_vertices(std::size_t count, bool finite) {
  constexpr float kTiny = std::numeric_limits<float>::min();
  const float values[] = {0.0f,
                          -0.0f,
                          1.0f,
                          std::nextafter(1.0f, 2.0f),
                          std::nextafter(1.0f, 0.0f),
                          -1.0f,
                          kTiny,
                          -kTiny,
                          kTiny / 2,
                          -kTiny / 4,
                          2 * kTiny,
                          std::numeric_limits<float>::denorm_min(),
                          1e30f,
                          -3e38f,
                          3e38f,
                          0.3f,
                          std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()};
  tests::Random random(7);
  const std::size_t choices = std::size(values) - (finite ? 3 : 0);
  std::vector<geometry::Vec3f> vertices(count);
  for (geometry::Vec3f& v : vertices) {
    const auto pick = [&] { return values[random.below(choices)]; };
    v = {pick(), pick(), pick()};
  }
  return vertices;
}

using EveryTarget = tests::OnSimdTarget;

TEST_P(EveryTarget, ReferencesAndSumsEqualOneByOne) {
  tests::Random random(3);
  for (const bool finite : {true, false}) {
    const std::vector<geometry::Vec3f> vertices = odd_vertices(finite ? 400 : 4000, finite);
    std::vector<geometry::Face> faces;
    for (int i = 0; i < 4000; ++i) {
      const auto corner = [&] { return static_cast<std::uint32_t>(random.below(vertices.size())); };
      faces.push_back({corner(), corner(), corner()});
      if (i % 40 == 0)
        faces.push_back({geometry::kNoVertex, geometry::kNoVertex, geometry::kNoVertex});
    }
    faces.push_back({static_cast<std::uint32_t>(vertices.size() - 1), 0, 1});
    const geometry::MeshView mesh{vertices, faces};
    std::vector<kdtree::Reference> made(faces.size());
    made.resize(face_references(mesh, 0, faces.size(), made.data()));
    std::size_t at = 0;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const auto box = face_bounds(mesh, i);
      if (!box) continue;
      ASSERT_LT(at, made.size());
      ASSERT_EQ(made[at].id, i);
      ASSERT_EQ(made[at].weight, 1u);
      ASSERT_EQ(made[at].bounds(), *box) << i;
      ++at;
    }
    EXPECT_EQ(at, made.size());
    for (std::size_t begin = 0; begin < faces.size(); begin += 16) {
      const std::size_t end = std::min(begin + 16, faces.size());
      geometry::Aabb box;
      std::uint64_t count = 0;
      for (std::size_t i = begin; i < end; ++i) {
        if (const auto b = face_bounds(mesh, i)) {
          box.grow(*b);
          ++count;
        }
      }
      const FaceSum sum = sum_faces(mesh, begin, end);
      ASSERT_EQ(sum.finite, count);
      ASSERT_EQ(sum.box, box);
      ASSERT_EQ(sum.first_bad, FaceSum::kNone);
    }
  }
}

TEST_P(EveryTarget, BadIndicesAreNeverRead) {
  const std::vector<geometry::Vec3f> vertices(5);
  const std::vector<geometry::Face> faces{
      {0, 1, 2}, {2, 3, 5}, {geometry::kNoVertex, 0, 1}, {0, 1, geometry::kNoVertex}};
  const FaceSum sum = sum_faces({vertices, faces}, 0, faces.size());
  EXPECT_EQ(sum.triangles, 4u);
  EXPECT_EQ(sum.finite, 1u);
  EXPECT_EQ(sum.first_bad, 1u);
  EXPECT_EQ(sum_faces({{}, faces}, 0, 1).first_bad, 0u);
}

TEST(FaceSum, OfNoFacesIsEmpty) {
  const std::vector<geometry::Vec3f> vertices{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}};
  const std::vector<geometry::Face> faces{
      {0, 1, 2}, {geometry::kNoVertex, geometry::kNoVertex, geometry::kNoVertex}};
  FaceSum sum = sum_faces({vertices, faces}, 0, 1);
  const geometry::Aabb box = sum.box;
  sum.add(sum_faces({vertices, faces}, 1, 2));
  EXPECT_EQ(sum.box, box);
  FaceSum nothing = sum_faces({vertices, faces}, 1, 2);
  nothing.add(sum_faces({vertices, faces}, 1, 2));
  EXPECT_TRUE(nothing.box.empty());
}

INSTANTIATE_TEST_SUITE_P(FaceBoxes, EveryTarget, tests::every_simd_target(),
                         tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::mesh
