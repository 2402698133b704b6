// Composition, inversion, refusal.
#include "scenegraph/model/affine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "accel/geometry/exact_sum.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/random.h"

namespace sightline::scenegraph::model {
namespace {

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Affine, InverseIsTheInverse) {
  tests::Random random(1);
  for (int round = 0; round < 1000; ++round) {
    Affine a;
    for (double& x : a.m) x = random.uniform(-2, 2);
    const auto back = inverse(a);
    if (!back || condition(a, *back) > 1e4) continue;
    const Vec3d p{random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5)};
    expect_near(back->point(a.point(p)), p, 1e-9);
    expect_near(compose(*back, a).point(p), p, 1e-9);
  }
}

/// The largest entry of a (b a - 1) in the linear parts, with exact sums: how far a point of the
/// unit cube comes back from where it was taken.
double way_back(const Affine& a, const Affine& b) {
  double most = 0;
  std::array<Vec3d, 3> residual;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      accel::geometry::ExactSum sum(row == column ? -1 : 0);
      for (std::size_t k = 0; k < 3; ++k) sum.add_product(b.m[4 * row + k], a.m[4 * k + column]);
      residual[column][row] = sum.estimate();
    }
  }
  for (const Vec3d& column : residual) {
    const Vec3d back = a.direction(column);
    most = std::max({most, std::fabs(back.x), std::fabs(back.y), std::fabs(back.z)});
  }
  return most;
}

TEST(Affine, InverseIsOffInProportionToTheCondition) {
  tests::Random random(2);
  int most_tested = 0;
  for (int round = 0; round < 2000; ++round) {
    const double first = std::exp2(random.uniform(0, 36));
    const double second = random.below(2) == 0 ? 1 : std::exp2(random.uniform(0, 36));
    const Affine scale{{first, 0, 0, 0, 0, second, 0, 0, 0, 0, 1, 0}};
    const Affine turn = random_frame(random, tests::Frames::kRigid, 1);
    const Affine a = compose(compose(turn, scale), random_frame(random, tests::Frames::kRigid, 1));
    const auto back = inverse(a);
    if (!back) continue;
    double size = 0;
    for (std::size_t row = 0; row < 3; ++row)
      size = std::max({size, std::fabs(a.m[4 * row]), std::fabs(a.m[4 * row + 1]),
                       std::fabs(a.m[4 * row + 2])});
    EXPECT_LE(way_back(a, *back), 0x1p-48 * condition(a, *back) * size) << first << ' ' << second;
    ++most_tested;
  }
  EXPECT_GT(most_tested, 1000);
}

TEST(Affine, ComposeAppliesTheInnerFirst) {
  const Affine scale{{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}};
  const Affine shift{{1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 0}};
  EXPECT_EQ(compose(shift, scale).point({1, 1, 1}), (Vec3d{12, 2, 2}));
  EXPECT_EQ(compose(scale, shift).point({1, 1, 1}), (Vec3d{22, 2, 2}));
}

TEST(Affine, TransposedInverseTransformsNormals) {
  const Affine squash{{1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 1, 0}};
  const Vec3d n = inverse(squash)->transposed({1, 1, 0});
  const Vec3d along = squash.direction({1, -1, 0});
  EXPECT_NEAR(dot(n, along), 0, 1e-12);
}

TEST(Affine, RefusesSingularTransforms) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(inverse(Affine{{1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0}}));
  EXPECT_FALSE(inverse(Affine{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}}));
  EXPECT_FALSE(inverse(Affine{{nan, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}));
  EXPECT_FALSE(inverse(Affine{{1, 0, 0, nan, 0, 1, 0, 0, 0, 0, 1, 0}}));
  EXPECT_FALSE(inverse(Affine{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e-13, 0}}));
  EXPECT_TRUE(inverse(Affine{{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e-9, 0}}));
}

}  // namespace
}  // namespace sightline::scenegraph::model
