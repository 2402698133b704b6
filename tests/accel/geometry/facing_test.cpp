// The side of a triangle that a ray meets.
#include "accel/geometry/facing.h"

#include <gtest/gtest.h>

#include "accel/geometry/intersect.h"
#include "tests/support/random.h"

namespace sightline::accel::geometry {
namespace {

const Vec3f kA{0, 0, 0}, kB{1, 0, 0}, kC{0, 1, 0};  // counterclockwise from +z

LocalRay ray_along(const Vec3d& direction) { return *make_local_ray({0.25, 0.25, 3}, direction); }

TEST(Facing, IsTheSignOfTheNormalAlongTheRay) {
  EXPECT_EQ(facing(ray_along({0, 0, -1}), kA, kB, kC), -1);
  EXPECT_EQ(facing(ray_along({0, 0, 1}), kA, kB, kC), 1);
  EXPECT_EQ(facing(ray_along({0, 0, -1}), kA, kC, kB), 1);
  EXPECT_EQ(facing(ray_along({1, 2, 0}), kA, kB, kC), 0);
}

TEST(Facing, IsExactWhereDoublesRound) {
  // The normal's z is 2^-120 or its opposite; in doubles the products cancel.
  const Vec3f a{1, 1, 0}, b{1 + 0x1p-20f, 1 + 0x1p-20f, 0};
  const LocalRay down = ray_along({0, 0, -1});
  const Vec3f left{1 + 0x1p-19f, 1 + 0x1p-19f + 0x1p-23f, 0};
  EXPECT_EQ(facing(down, a, b, left), -1);
  EXPECT_EQ(facing(down, a, left, b), 1);
  // Nearly edge-on: the last bit of the ray's slope decides.
  const double tiny = 0x1p-200;
  EXPECT_EQ(facing(ray_along({1, 0.5, -tiny}), kA, kB, kC), -1);
  EXPECT_EQ(facing(ray_along({1, 0.5, tiny}), kA, kB, kC), 1);
}

TEST(Facing, IsNeverEdgeOnForAHit) {
  tests::Random random(3);
  int hits = 0;
  for (int i = 0; i < 20'000; ++i) {
    // On a lattice many rays lie in the planes of triangles and pass through their edges.
    const auto x = [&] { return static_cast<float>(random.below(4)); };
    const auto y = [&] { return static_cast<double>(random.below(5)) - 2; };
    const Vec3f a{x(), x(), x()}, b{x(), x(), x()}, c{x(), x(), x()};
    const auto ray = make_local_ray({y(), y(), y()}, {y(), y(), y()});
    if (!ray || !intersect(*ray, a, b, c)) continue;
    ++hits;
    const int side = facing(*ray, a, b, c);
    EXPECT_NE(side, 0);
    EXPECT_EQ(facing(*ray, b, a, c), -side);
    EXPECT_EQ(is_culled(Culling::kBack, *ray, a, b, c), side == 1);
    EXPECT_EQ(is_culled(Culling::kFront, *ray, a, b, c), side == -1);
    EXPECT_FALSE(is_culled(Culling::kNone, *ray, a, b, c));
  }
  EXPECT_GT(hits, 500);
}

}  // namespace
}  // namespace sightline::accel::geometry
