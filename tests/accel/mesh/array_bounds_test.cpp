// Streaming passes over arrays equal one-by-one loops, at every length, on every SIMD target.
#include "accel/mesh/array_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "tests/accel/simd_targets.h"
#include "tests/support/random.h"

namespace sightline::accel::mesh {
namespace {

using ArrayBoundsOnTarget = tests::OnSimdTarget;

TEST_P(ArrayBoundsOnTarget, FindsTheGreatestIndexAtEveryPosition) {
  tests::Random random(1);
  EXPECT_EQ(greatest_index({}), 0u);
  for (std::size_t count = 1; count < 70; ++count) {
    std::vector<geometry::Face> faces(count);
    for (std::size_t at = 0; at < 3 * count; ++at) {
      for (geometry::Face& face : faces) {
        for (std::uint32_t& v : face) v = static_cast<std::uint32_t>(random.below(1000));
      }
      faces[at / 3][at % 3] = at % 2 == 0 ? 1000 : geometry::kNoVertex;
      ASSERT_EQ(greatest_index(faces), faces[at / 3][at % 3]) << count << " " << at;
    }
  }
}

TEST_P(ArrayBoundsOnTarget, BoundsAreTight) {
  tests::Random random(2);
  EXPECT_FALSE(bounds_of_vertices({}));
  for (std::size_t count = 1; count < 200; ++count) {
    std::vector<geometry::Vec3f> vertices(count);
    geometry::Aabb expected;
    for (geometry::Vec3f& v : vertices) {
      v = geometry::Vec3f(
          geometry::Vec3d{random.uniform(-3, 1), random.uniform(5, 6), random.uniform(-1, 1e30)});
      expected.grow(v);
    }
    const auto box = bounds_of_vertices(vertices);
    ASSERT_TRUE(box);
    ASSERT_EQ(*box, expected);
    constexpr float kOdd[] = {std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity()};
    for (std::size_t at = 0; at < 3 * count; ++at) {
      const float before = vertices[at / 3][at % 3];
      vertices[at / 3][at % 3] = kOdd[at % std::size(kOdd)];
      ASSERT_FALSE(bounds_of_vertices(vertices)) << count << " " << at;
      vertices[at / 3][at % 3] = before;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Every, ArrayBoundsOnTarget, tests::every_simd_target(),
                         tests::simd_target_name);

TEST(ArrayBounds, OfEveryNthFace) {
  const std::vector<geometry::Vec3f> vertices{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {9, 9, 9}};
  const std::vector<geometry::Face> faces{{0, 1, 2}, {0, 1, 3}, {2, 1, 0}};
  EXPECT_EQ(bounds_of_faces({vertices, faces}, 2), (geometry::Aabb{{0, 0, 0}, {1, 2, 0}}));
  EXPECT_EQ(bounds_of_faces({vertices, faces}, 1), (geometry::Aabb{{0, 0, 0}, {9, 9, 9}}));
}

}  // namespace
}  // namespace sightline::accel::mesh
