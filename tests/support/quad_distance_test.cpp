// The distance in 113 bits, and the bounds in doubles, against exact distances.
#include "tests/support/quad_distance.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/support/distance_bounds.h"
#include "tests/support/random.h"
#include "tests/support/rational_distance.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;
using LocalFace = std::array<Vec3f, 3>;

struct Tally {
  int decided = 0, all = 0;
};

void compare_exactly(const Vec3d& p, const Affine& m, const LocalFace& face, Tally& tally) {
  const double exact = rational_distance(p, m.m, face[0], face[1], face[2]);
  const auto quick = quad_distance(p, m, face[0], face[1], face[2]);
  ++tally.all;
  if (quick) {
    ++tally.decided;
    ASSERT_EQ(*quick, exact);
  }
}

// Coordinates are multiples of size / 2^20, which are floats if the size is a power of two.
Vec3f random_corner(Random& random, const Vec3d& size) {
  Vec3f corner;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double steps = static_cast<double>(random.below(1u << 21)) - (1 << 20);
    corner[axis] = static_cast<float>(size[axis] * steps * 0x1p-20);
  }
  return corner;
}

// Above the face, on it, beside it, on an edge and on a corner, at a distance of about `scale`.
std::array<Vec3d, 6> points_near(const Affine& m, const LocalFace& face, double scale,
                                 Random& random) {
  const Vec3d a = m.point(Vec3d(face[0])), b = m.point(Vec3d(face[1])), c = m.point(Vec3d(face[2]));
  const Vec3d inside = a * 0.25 + b * 0.375 + c * 0.375, edge = (a + b) * 0.5;
  const Vec3d step = random.direction() * scale;
  return {inside + step, inside, edge + step, edge, a + step, a};
}

Tally compare_family(const Affine& m, const Vec3d& size, double scale, std::uint64_t seed) {
  Tally tally;
  Random random(seed);
  for (int round = 0; round < 60; ++round) {
    LocalFace face;
    for (Vec3f& v : face) v = random_corner(random, size);
    if (round % 10 == 0) face[2] = face[1];
    if (round % 30 == 0) face[1] = face[2] = face[0];
    for (const Vec3d& p : points_near(m, face, scale, random)) compare_exactly(p, m, face, tally);
  }
  return tally;
}

TEST(QuadDistance, DecidesMostFacesAndAgrees) {
  for (const double scale : {1e-6, 1e-2, 1.0, 1e3, 1e9}) {
    const Tally tally = compare_family({}, {1, 1, 1}, scale, 1);
    EXPECT_GE(tally.decided, tally.all * 4 / 10) << scale;
  }
}

TEST(QuadDistance, AgreesInHardFamilies) {
  const Affine sheared{{1e6, 0.5, 0.25, 1, 1e6, -0.3, 0.1, 2, 0.7e6, 0, 0.9, 3}};
  const Affine mirrored{{-1, 0, 0, 1e7, 0, 0.1, 1, -1e7, 0, 1, 0.1, 1e7}};
  const Affine thin{{1, 0, 0, 0, 0, 1e-12, 0, 0, 0, 0, 1, 0}};
  const Affine tiny{{1e-300, 0, 0, 0, 0, 1e-300, 0, 0, 0, 0, 1e-300, 0}};
  std::uint64_t seed = 2;
  for (const Affine& m : {Affine{}, sheared, mirrored, thin, tiny}) {
    for (const Vec3d& size : {Vec3d{1, 1, 1}, Vec3d{0x1p+27, 1, 1}, Vec3d{0x1p+27, 1, 0x1p-27}}) {
      for (const double scale : {1e-15, 1e-8, 1e-3, 10.0}) compare_family(m, size, scale, ++seed);
    }
  }
}

// The terms of coordinates are 1e16 times as large as the distance, so that 113 bits are not more
// than enough.
TEST(QuadDistance, AgreesWhereLargeTermsCancel) {
  const Affine far{{0.1, 0.7, 0.3, 1e15, -0.6, 0.3, 0.7, -1e15, 0.9, 0.1, -0.2, 1e15}};
  Tally tally;
  Random random(4);
  for (int round = 0; round < 3000; ++round) {
    const Vec3f v = random_corner(random, {1, 1, 1});
    compare_exactly(far.point(Vec3d(v)), far, {v, v, v}, tally);
  }
  EXPECT_GE(tally.decided, tally.all / 4);
}

TEST(QuadDistance, LeavesHalvesToIntegers) {
  const LocalFace face{Vec3f{0, 0, 0}, Vec3f{4, 0, 0}, Vec3f{0, 4, 0}};
  const auto above = [&](double z) {
    const Affine down{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -z}};
    return quad_distance({1, 1, 1}, down, face[0], face[1], face[2]);
  };
  EXPECT_EQ(above(0), 1);
  EXPECT_EQ(above(0x1p-53), std::nullopt);
  EXPECT_EQ(above(0x3p-53), std::nullopt);
  EXPECT_EQ(above(0x1p-53 + 0x1p-90), 1 + 0x1p-52);
  EXPECT_EQ(above(0x1p-53 - 0x1p-90), 1);
  EXPECT_EQ(quad_distance({1, 1, 0}, {}, face[0], face[1], face[2]), std::nullopt) << "on the face";
}

TEST(DistanceBounds, ContainTheDistanceInDoubles) {
  Random random(3);
  for (int round = 0; round < 3000; ++round) {
    const double thin = std::ldexp(1, -static_cast<int>(random.below(40)));
    const double near = std::ldexp(1, 3 - static_cast<int>(random.below(60)));
    std::array<Vec3f, 3> face;
    for (Vec3f& v : face) v = random_corner(random, {1, thin, 1});
    const double u = random.uniform();
    const Vec3d p = Vec3d(face[0]) * u + Vec3d(face[round % 2 == 0 ? 1 : 2]) * (1 - u) +
                    random.direction() * near;
    std::array<Vec3d, 3> seen;
    double reach = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      seen[i] = Vec3d(face[i]) - p;
      reach = std::max(reach, length(seen[i]));
    }
    const auto bounds = distance_bounds(seen, 34 * Precision<double>::kUnit * reach * 1.001);
    const double exact = rational_distance(p, Affine{}.m, face[0], face[1], face[2]);
    ASSERT_LE(bounds.lower, exact);
    ASSERT_GE(bounds.upper, exact);
    // A guess that is right is also close, unless the point is almost on the face.
    if (near > 1e-3 && thin > 0.1) {
      ASSERT_LT(bounds.upper - bounds.lower, 1e-9);
    }
  }
}

}  // namespace
}  // namespace sightline::tests
