// Composition, inversion, refusal.
#include "scenegraph/model/affine.h"

#include <gtest/gtest.h>

#include <limits>

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
