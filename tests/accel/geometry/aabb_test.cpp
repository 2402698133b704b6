// Widening and membership.
#include "accel/geometry/aabb.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace sightline::accel::geometry {
namespace {

TEST(WidenFlat, GivesEveryAxisAPositiveExtent) {
  const Aabb flat{{1, -2, 0}, {1, 3, 0}};
  const Aabb wide = widen_flat(flat);
  EXPECT_EQ(wide.lo, flat.lo);
  EXPECT_GT(wide.hi.x, 1.0f);
  EXPECT_EQ(wide.hi.x, std::nextafter(1.0f, 2.0f));
  EXPECT_EQ(wide.hi.y, 3.0f);
  EXPECT_GT(wide.hi.z, 0.0f);
}

TEST(WidenFlat, LeavesNoDenormalBounds) {
  const float tiny = std::numeric_limits<float>::min();
  const Aabb box = widen_flat({{-1e-40f, 1e-40f, -1e-40f}, {1e-40f, 2e-40f, -1e-41f}});
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_TRUE(box.lo[a] == 0 || std::fabs(box.lo[a]) >= tiny);
    EXPECT_TRUE(box.hi[a] == 0 || std::fabs(box.hi[a]) >= tiny);
    EXPECT_GE(box.hi[a] - box.lo[a], tiny);
  }
  EXPECT_LE(box.lo.x, -1e-40f);
  EXPECT_GE(box.hi.x, 1e-40f);
}

TEST(Common, IsThePartInBothBoxes) {
  const Aabb box{{0, 0, 0}, {2, 2, 2}};
  EXPECT_EQ(common(box, {{1, -1, 0}, {3, 1, 2}}), (Aabb{{1, 0, 0}, {2, 1, 2}}));
  EXPECT_FALSE(common(box, {{2, 0, 0}, {3, 2, 2}}).empty());
  EXPECT_TRUE(common(box, {{3, 0, 0}, {4, 2, 2}}).empty());
}

TEST(Rounding, IsOutward) {
  EXPECT_LE(static_cast<double>(round_down(0.1)), 0.1);
  EXPECT_GE(static_cast<double>(round_up(0.1)), 0.1);
  EXPECT_EQ(round_down(0.5), 0.5f);
  EXPECT_EQ(round_up(-0.5), -0.5f);
}

/// A sift tests membership one plane at a time, is_member tests it for the whole cell; the order of
/// splits must not matter.
TEST(Membership, DoesNotDependOnThePathOfSplits) {
  tests::Random random(7);
  // A coarse lattice, so that bounds and planes coincide often.
  const auto lattice = [&] { return static_cast<float>(random.below(9)); };
  for (int round = 0; round < 20000; ++round) {
    Aabb box;
    box.grow(Vec3f{lattice(), lattice(), lattice()});
    box.grow(Vec3f{lattice(), lattice(), lattice()});
    const Aabb bounds = widen_flat(box);
    Aabb cell{{-1, -1, -1}, {10, 10, 10}};
    bool member = true;
    for (int cut = 0; cut < 6; ++cut) {
      const auto axis = random.below(3);
      const float x = lattice();
      if (!(x > cell.lo[axis] && x < cell.hi[axis])) continue;
      const HalvedCell halves = halve(cell, static_cast<int>(axis), x);
      const bool left = random.below(2) == 0;
      cell = left ? halves.left : halves.right;
      member = member && (left ? bounds.lo[axis] < x : bounds.hi[axis] > x);
    }
    ASSERT_EQ(member, is_member(bounds, cell));
  }
}

/// Every point of a box lies in a closed cell that the box is a member of; this includes points on
/// the planes between cells.
TEST(Membership, CoversEveryPointOfABox) {
  tests::Random random(8);
  const auto lattice = [&] { return static_cast<float>(random.below(5)); };
  for (int round = 0; round < 2000; ++round) {
    Aabb box;
    box.grow(Vec3f{lattice(), lattice(), lattice()});
    box.grow(Vec3f{lattice(), lattice(), lattice()});
    const Aabb bounds = widen_flat(box);
    const Vec3f p{std::min(box.hi.x, std::max(box.lo.x, lattice())),
                  std::min(box.hi.y, std::max(box.lo.y, lattice())),
                  std::min(box.hi.z, std::max(box.lo.z, lattice()))};
    // The grid of unit cells: p lies in up to eight of them.
    bool covered = false;
    for (int i = 0; i < 8; ++i) {
      const Vec3f lo{p.x - static_cast<float>(i & 1), p.y - static_cast<float>(i >> 1 & 1),
                     p.z - static_cast<float>(i >> 2)};
      covered = covered || is_member(bounds, {lo, lo + Vec3f{1, 1, 1}});
    }
    ASSERT_TRUE(covered);
  }
}

}  // namespace
}  // namespace sightline::accel::geometry
