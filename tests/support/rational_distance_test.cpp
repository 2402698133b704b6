// The exact distance on cases that are decided by hand.
#include "tests/support/rational_distance.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/support/random.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using Rows = std::array<double, 12>;

constexpr Rows kUnchanged{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
constexpr double kLeastDouble = std::numeric_limits<double>::denorm_min();

constexpr Rows moved_by(const Vec3d& t) { return {1, 0, 0, t.x, 0, 1, 0, t.y, 0, 0, 1, t.z}; }

// From (0, 0, 0) (4, 0, 0) (0, 4, 0).
double from_corner_face(const Vec3d& p, const Rows& m = kUnchanged) {
  return rational_distance(p, m, {0, 0, 0}, {4, 0, 0}, {0, 4, 0});
}

double from_vertex(const Vec3d& p, const Vec3f& v, const Rows& m = kUnchanged) {
  return rational_distance(p, m, v, v, v);
}

// Whether r is the root of x rounded to nearest: x is between the squares of the two halves.
bool is_rounded_root(const mpq_class& x, double r) {
  const mpq_class above = (mpq_class(r) + mpq_class(std::nextafter(r, HUGE_VAL))) / 2;
  if (x > above * above) return false;
  if (r == 0) return true;
  const mpq_class below = (mpq_class(r) + mpq_class(std::nextafter(r, 0.0))) / 2;
  return x >= below * below;
}

TEST(RationalDistance, AboveTheInside) {
  EXPECT_EQ(from_corner_face({1, 1, 3}), 3);
  EXPECT_EQ(from_corner_face({1, 1, -0.1}), 0.1);
  EXPECT_EQ(from_corner_face({1, 1, 0}), 0);
  EXPECT_EQ(from_corner_face({0.1, 0.2, 1e-60}), 1e-60);
}

TEST(RationalDistance, BeyondEdges) {
  EXPECT_EQ(from_corner_face({2, -3, 4}), 5);
  EXPECT_EQ(from_corner_face({-5, 2, 12}), 13);
  EXPECT_EQ(from_corner_face({3, 3, 0}), std::sqrt(2.0));
  EXPECT_EQ(from_corner_face({2, 2, 7}), 7) << "above the third edge";
  EXPECT_EQ(from_corner_face({2, -1e-100, 0}), 0) << "counts as zero";
  EXPECT_EQ(from_corner_face({2, -0x1p-250, 0}), 0x1p-250);
}

TEST(RationalDistance, BeyondCorners) {
  EXPECT_EQ(from_corner_face({-3, -4, 0}), 5);
  EXPECT_EQ(from_corner_face({-2, -3, 6}), 7);
  EXPECT_EQ(from_corner_face({7, -4, 0}), 5);
  EXPECT_EQ(from_corner_face({-4, 4, 3}), 5);
  EXPECT_EQ(from_corner_face({-1, 8, 0}), std::sqrt(17.0));
  EXPECT_EQ(from_corner_face({4, 0, 0}), 0);
}

TEST(RationalDistance, FacesWithoutAreaAreSegmentsAndPoints) {
  EXPECT_EQ(from_vertex({1, 2, 2}, {0, 0, 0}), 3);
  EXPECT_EQ(rational_distance({5, 3, 4}, kUnchanged, {0, 0, 0}, {9, 0, 0}, {9, 0, 0}), 5);
  EXPECT_EQ(rational_distance({5, 3, 4}, kUnchanged, {9, 0, 0}, {9, 0, 0}, {0, 0, 0}), 5);
  EXPECT_EQ(rational_distance({12, 4, 0}, kUnchanged, {0, 0, 0}, {4, 0, 0}, {9, 0, 0}), 5);
  EXPECT_EQ(rational_distance({-3, 4, 0}, kUnchanged, {4, 0, 0}, {9, 0, 0}, {0, 0, 0}), 5);
  EXPECT_EQ(rational_distance({7, 0, 1}, kUnchanged, {4, 0, 0}, {9, 0, 0}, {0, 0, 0}), 1);
  // A transform that flattens the face.
  EXPECT_EQ(from_corner_face({1, 3, 4}, {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}), 5);
}

TEST(RationalDistance, HalvesOfAnUlpRoundToEven) {
  const auto above = [](double z) { return from_corner_face({1, 1, 1}, moved_by({0, 0, -z})); };
  EXPECT_EQ(above(0x1p-53), 1);
  EXPECT_EQ(above(0x1p-53 + 0x1p-105), 1 + 0x1p-52);
  EXPECT_EQ(above(0x3p-53 - 0x1p-104), 1 + 0x1p-52);
  EXPECT_EQ(above(0x3p-53), 1 + 0x1p-51);
  EXPECT_EQ(above(0x1p-53 + 0x1p-104), 1 + 0x1p-52);
  // Above half by a part of 2^-1400.
  EXPECT_EQ(from_vertex({0, 0, 1}, {0, 0, 0}, moved_by({0x1p-700, 0, -0x1p-53})), 1 + 0x1p-52);
  // Five times 1 + s is 2.5 ulp and 7.5 ulp above five.
  const auto beyond_corner = [](double s) {
    return from_vertex({3, 4, 0}, {0, 0, 0}, moved_by({-3 * s, -4 * s, 0}));
  };
  EXPECT_EQ(beyond_corner(0x1p-51), 5 + 0x2p-50);
  EXPECT_EQ(beyond_corner(0x3p-51), 5 + 0x8p-50);
  EXPECT_EQ(beyond_corner(0x1p-51 + 0x1p-100), 5 + 0x3p-50);
  EXPECT_EQ(beyond_corner(0x3p-51 - 0x1p-100), 5 + 0x7p-50);
}

TEST(RationalDistance, TinyAndDenormalResults) {
  EXPECT_EQ(from_corner_face({1, 1, 0}, moved_by({0, 0, 1e-310})), 1e-310);
  EXPECT_EQ(from_vertex({0, 0, 0}, {0, 0, 0}, moved_by({0x3p-1015, 0x4p-1015, 0})), 0x5p-1015);
  EXPECT_EQ(from_vertex({0, 0, 0}, {0, 0, 0}, moved_by({3 * kLeastDouble, 4 * kLeastDouble, 0})),
            5 * kLeastDouble);
  const auto scaled = [](float z) {
    return from_vertex({0, 0, 0}, {0, 0, z}, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, kLeastDouble, 0});
  };
  EXPECT_EQ(scaled(0.5f), 0) << "half of the least double, to even";
  EXPECT_EQ(scaled(0.50001f), kLeastDouble);
  EXPECT_EQ(scaled(1.5f), 2 * kLeastDouble);
  EXPECT_EQ(scaled(2.5f), 2 * kLeastDouble);
  EXPECT_EQ(scaled(1e-40f), 0);
  const Rows twice{0, 0, 0, 0, 0, 1, 0, 0, kLeastDouble, 0, kLeastDouble, 0};
  EXPECT_EQ(from_vertex({0, 0, 0}, {0x1p-60f, 0, 0.5f}, twice), kLeastDouble) << "rounded once";
  EXPECT_EQ(from_vertex({0, 0, 0}, {1e-45f, 0, 0}), 0x1p-149);
}

TEST(RationalDistance, LargeNumbers) {
  const double far = 0x1p+249;
  EXPECT_EQ(from_vertex({3 * far, 0, 4 * far}, {0, 0, 0}), 5 * far);
  EXPECT_EQ(from_vertex({far, 0, 0}, {1, 1, 1}), far);
  const Vec3d at{1e7, -1e7, 1e7};
  EXPECT_EQ(from_corner_face(at + Vec3d{1, 1, 0.0009765625}, moved_by(at)), 0.0009765625);
  EXPECT_EQ(from_corner_face(at + Vec3d{1, 1, 0.001}, moved_by(at)), (1e7 + 0.001) - 1e7);
  EXPECT_EQ(from_corner_face({2, -3, 4 + 1e7}, moved_by({0, 0, 1e7})), 5);
}

TEST(RationalDistance, PointCloudsHaveRoundedRoots) {
  Random random(7);
  const auto number = [&] { return static_cast<int>(random.below(2001)) - 1000; };
  for (int round = 0; round < 2000; ++round) {
    const int x = number(), y = number(), z = number();
    const int square = x * x + y * y + z * z;
    ASSERT_EQ(from_vertex({2.0 * x, 3, 5}, {static_cast<float>(x), static_cast<float>(3 - y),
                                            static_cast<float>(5 + z)}),
              std::sqrt(static_cast<double>(square)));
  }
}

// Edges and planes, whose squared distances are quotients of small integers.
TEST(RationalDistance, QuotientsHaveRoundedRoots) {
  Random random(8);
  const auto whole = [&](int from, int to) {
    return from + static_cast<int>(random.below(static_cast<std::uint64_t>(to - from + 1)));
  };
  for (int round = 0; round < 2000; ++round) {
    // The line through the origin along (x, y, 0), seen from above a point of it.
    const int x = whole(1, 50), y = whole(1, 50), px = whole(1, 50), py = whole(1, 50);
    const Vec3f end{static_cast<float>(100 * x), static_cast<float>(100 * y), 0};
    const int off = x * py - y * px;
    const mpq_class square = mpq_class(off * off) / mpq_class(x * x + y * y);
    const double edge = rational_distance({1.0 * px, 1.0 * py, 0}, kUnchanged, {0, 0, 0}, end, end);
    ASSERT_TRUE(is_rounded_root(square, edge)) << edge;
    // The plane through (0, 0, 0), (0, 1, 0) and that line, turned up.
    const Vec3f up{static_cast<float>(100 * x), 0, static_cast<float>(100 * y)};
    const double plane =
        rational_distance({1.0 * px, 0, 1.0 * py}, kUnchanged, {0, -900, 0}, {0, 900, 0}, up);
    ASSERT_TRUE(is_rounded_root(square, plane)) << plane;
  }
}

TEST(RationalDistance, CornersMayBePermutedAndAxesMirrored) {
  Random random(9);
  const auto vertex = [&] {
    const Vec3d d = random.direction();
    return Vec3f(d * random.uniform(0, 2));
  };
  for (int round = 0; round < 300; ++round) {
    const Vec3f a = vertex(), b = vertex(), c = vertex();
    const Vec3d p = random.direction() * random.uniform(0, 3);
    const double distance = rational_distance(p, kUnchanged, a, b, c);
    ASSERT_EQ(rational_distance(p, kUnchanged, b, c, a), distance);
    ASSERT_EQ(rational_distance(p, kUnchanged, c, b, a), distance);
    const Rows mirrored{0, -1, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0};
    ASSERT_EQ(rational_distance({-p.y, p.x, -p.z}, mirrored, b, a, c), distance);
    // No point of the face is nearer.
    double least = HUGE_VAL;
    for (int u = 0; u <= 8; ++u) {
      for (int v = 0; u + v <= 8; ++v) {
        const Vec3d x =
            Vec3d(a) * ((8 - u - v) / 8.0) + Vec3d(b) * (u / 8.0) + Vec3d(c) * (v / 8.0);
        least = std::min(least, length(x - p));
      }
    }
    ASSERT_LE(distance, least * (1 + 1e-14));
    ASSERT_LE(least, distance + 0.5);
  }
}

}  // namespace
}  // namespace sightline::tests
