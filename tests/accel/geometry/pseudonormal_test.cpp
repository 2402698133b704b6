// Normals and nearest points in double-doubles are those in integers, wherever their bounds hold,
// and a face contains its nearest point.
#include "accel/geometry/pseudonormal.h"

#include <gtest/gtest.h>

#include <cmath>

#include "accel/geometry/intersect.h"
#include "tests/accel/geometry/closest_cases.h"

namespace sightline::accel::geometry {
namespace {

double largest_difference(const Vec3dd& a, const Vec3dd& b) { return max_norm(high(a - b)); }

class Pseudonormal : public testing::TestWithParam<ClosestFamily> {};

TEST_P(Pseudonormal, InDoubleDoublesIsThatInIntegers) {
  tests::Random random(99);
  for (int i = 0; i < 6'000; ++i) {
    const ClosestCase c = GetParam().make(random);
    const double distance = c.distance();
    if (distance == 0 || std::isinf(distance)) continue;
    const NearestPoint exact = exact_nearest(c.p, c.matrix, c.vertices, distance);
    NearestPoint nearest;
    if (computed_nearest(c.p, c.matrix, c.vertices, distance, nearest)) {
      ASSERT_EQ(nearest.feature.part, exact.feature.part);
      ASSERT_EQ(nearest.feature.index, exact.feature.index);
      ASSERT_LE(largest_difference(nearest.from_p, exact.from_p), 0x1p-44);
      ASSERT_LE(max_norm(nearest.position - exact.position), nearest.off);
    }
    const FaceNormal exact_face = exact_normal(exact.view, c.matrix, c.vertices);
    FaceNormal face;
    if (computed_normal(exact.view, c.matrix, c.vertices, face)) {
      ASSERT_LE(largest_difference(face.normal, exact_face.normal), 0x1p-44);
      ASSERT_LE(std::fabs((face.area - exact_face.area).high), 0x1p-44 * exact_face.area.high);
    }
    if (exact_face.area.high == 0) continue;
    ASSERT_NE(part_at(exact_face, exact.seen, exact.seen_off).part, Part::kUnknown);
  }
}

INSTANTIATE_TEST_SUITE_P(AllFamilies, Pseudonormal, testing::ValuesIn(closest_families()),
                         [](const auto& family) { return family.param.name; });

constexpr std::array<double, 12> kUntransformed{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
constexpr std::array<Vec3f, 3> kTriangle{Vec3f{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};

TEST(Pseudonormal, OfATriangleIsKnown) {
  FaceNormal face;
  const Vec3d p{1, 1, 2};
  ASSERT_TRUE(computed_normal(p, kUntransformed, kTriangle, face));
  EXPECT_EQ(high(face.normal), (Vec3d{0, 0, 1}));
  EXPECT_EQ(face.area.high, 16);
  NearestPoint nearest;
  ASSERT_TRUE(computed_nearest(p, kUntransformed, kTriangle, 2, nearest));
  EXPECT_EQ(nearest.feature.part, Part::kInside);
  EXPECT_EQ(high(nearest.from_p), (Vec3d{0, 0, -1}));
  EXPECT_EQ(nearest.position, (Vec3d{1, 1, 0}));
}

TEST(Pseudonormal, IsWeightedByTheAngleAtAPoint) {
  const FaceNormal face = exact_normal({0, 0, 0}, kUntransformed, kTriangle);
  const auto angle = [&](const Vec3d& at) {
    const Vec3dd point{{at.x}, {at.y}, {at.z}};
    const Feature feature = part_at(face, point, 0);
    return feature.part == Part::kUnknown ? 0 : angle_at(face, feature).high;
  };
  const double pi = std::acos(-1);
  EXPECT_DOUBLE_EQ(angle({0, 0, 0}), pi / 2);
  EXPECT_DOUBLE_EQ(angle({4, 0, 0}), pi / 4);
  EXPECT_DOUBLE_EQ(angle({0, 4, 0}), pi / 4);
  EXPECT_DOUBLE_EQ(angle({0x1p-52, 0, 0}), pi);
  EXPECT_DOUBLE_EQ(angle({2, 2, 0}), pi);
  EXPECT_DOUBLE_EQ(angle({1, 1, 0}), 2 * pi);
  EXPECT_EQ(angle({1, 1, 0x1p-52}), 0);
  EXPECT_EQ(angle({-0x1p-52, 1, 0}), 0);
  EXPECT_EQ(angle({4.5, 0, 0}), 0);
}

TEST(Pseudonormal, KnowsWhichMatricesMirror) {
  EXPECT_FALSE(is_mirrored(kUntransformed));
  EXPECT_TRUE(is_mirrored({0, 1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7}));
  // Two axes that are 1e-12 of the third, nearly in its direction.
  EXPECT_FALSE(is_mirrored({1, 1, 1, 0, 0, 1e-12, 0, 0, 0, 0, 1e-12, 0}));
  EXPECT_TRUE(is_mirrored({1e200, 0, 0, 0, 0, -1e200, 0, 0, 0, 0, 1e200, 0}));
  EXPECT_TRUE(is_mirrored({1e-200, 0, 0, 0, 0, -1e-200, 0, 0, 0, 0, 1e-200, 0}));
}

}  // namespace
}  // namespace sightline::accel::geometry
