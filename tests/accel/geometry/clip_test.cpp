// Clipped bounds: they contain the clipped triangle and nothing outside the cell.
#include "accel/geometry/clip.h"

#include <gtest/gtest.h>

#include <array>

#include "accel/grow/clip_straddlers.h"
#include "accel/kdtree/reference.h"
#include "tests/support/random.h"

namespace sightline::accel::geometry {
namespace {

using Triangle = std::array<Vec3f, 3>;

Vec3f random_point(tests::Random& random, double lo, double hi) {
  const auto x = [&] { return static_cast<float>(random.uniform(lo, hi)); };
  return {x(), x(), x()};
}

Aabb random_cell(tests::Random& random, double lo, double hi) {
  Aabb cell;
  cell.grow(random_point(random, lo, hi));
  cell.grow(random_point(random, lo, hi));
  return cell;
}

Vec3d point_of(const Triangle& t, double u, double v) {
  return Vec3d(t[0]) * (1 - u - v) + Vec3d(t[1]) * u + Vec3d(t[2]) * v;
}

bool is_in(const Vec3d& p, const Aabb& box, double slack) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (p[a] < static_cast<double>(box.lo[a]) - slack ||
        p[a] > static_cast<double>(box.hi[a]) + slack)
      return false;
  }
  return true;
}

/// Points of the triangle inside the cell must be in the clipped box. The points are rounded by
/// less than `slack`, so only those that are certainly in the cell are tested.
void check_points(const Triangle& t, const Aabb& cell, double slack, tests::Random& random,
                  int& inside) {
  const auto box = clipped_bounds(t[0], t[1], t[2], cell);
  for (int i = 0; i < 60; ++i) {
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    if (i % 6 == 0) u = 0;
    if (i % 6 == 1) v = 1 - u;
    const Vec3d p = point_of(t, u, v);
    if (!is_in(p, cell, -slack)) continue;
    ++inside;
    ASSERT_TRUE(box);
    ASSERT_TRUE(is_in(p, *box, slack));
  }
}

TEST(Clip, ContainsEveryPointOfTheTriangleInTheCell) {
  tests::Random random(1);
  for (const double size : {1.0, 1e-3, 1e6}) {
    for (const double offset : {0.0, 1e3}) {
      int inside = 0;
      for (int round = 0; round < 3000; ++round) {
        const double lo = (offset - 1) * size, hi = (offset + 1) * size;
        Triangle t{random_point(random, lo, hi), random_point(random, lo, hi),
                   random_point(random, lo, hi)};
        if (round % 4 == 1) t[0].z = t[1].z = t[2].z;                       // flat
        if (round % 4 == 2) t[2] = t[1] + (t[0] - t[1]) * 0.37f;            // a sliver
        if (round % 4 == 3) t[1].x = t[0].x, t[1].y = t[0].y, t[2] = t[1];  // a line
        check_points(t, random_cell(random, lo, hi), size * (offset + 1) * 1e-14, random, inside);
      }
      EXPECT_GT(inside, 5000);
    }
  }
}

TEST(Clip, StaysInTheCellExceptForTheWidthOfFlatBoxes) {
  tests::Random random(2);
  int met = 0;
  for (int round = 0; round < 20000; ++round) {
    const Triangle t{random_point(random, 0, 1), random_point(random, 0, 1),
                     random_point(random, 0, 1)};
    const Aabb cell = random_cell(random, 0, 1);
    const auto box = clipped_bounds(t[0], t[1], t[2], cell);
    if (!box) continue;
    ++met;
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_GE(box->lo[a], cell.lo[a]);
      EXPECT_LE(box->hi[a], least_above(least_above(cell.hi[a])));
      EXPECT_LT(box->lo[a], box->hi[a]);
    }
  }
  EXPECT_GT(met, 1000);
}

TEST(Clip, IsTight) {
  // The hypotenuse x + y = 1 leaves the cell [0, 1] x [0.75, 1] at x = 0.25.
  const auto box = clipped_bounds({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {{0, 0.75f, -1}, {1, 1, 1}});
  ASSERT_TRUE(box);
  EXPECT_EQ(box->lo, (Vec3f{0, 0.75f, 0}));
  EXPECT_FLOAT_EQ(box->hi.x, 0.25f);
  EXPECT_GE(box->hi.x, 0.25f);
  EXPECT_EQ(box->hi.y, 1);
  EXPECT_EQ(box->hi.z, least_above(0));
  EXPECT_FALSE(clipped_bounds(
      {0, 0, 0}, {1, 0, 0}, {0, 1, 0},
      {{0.6f, 0.6f, -1}, {1, 1, 1}}));  // The boxes meet, the triangle and the cell do not
}

struct OneFace {
  std::vector<Vec3f> vertices;
  std::vector<Face> faces{{0, 1, 2}};
  MeshView view() const { return {vertices, faces}; }
};

TEST(ClipToHalf, OmitsTrianglesThatOnlyTouch) {
  const OneFace up{{{0, 0, 1}, {1, 0, 1}, {0, 1, 2}}};
  EXPECT_TRUE(grow::clip_to_half(up.view(), 0, {{0, 0, 1}, {1, 1, 2}}));
  EXPECT_FALSE(
      grow::clip_to_half(up.view(), 0, {{0, 0, 0}, {1, 1, 1}}));  // An edge in the upper face
}

TEST(ClipToHalf, KeepsTrianglesFlatInAFace) {
  const OneFace floor{{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}};
  for (const Aabb& cell : {Aabb{{0, 0, 0}, {0.5f, 1, 1}}, Aabb{{0, 0, 1}, {0.5f, 1, 2}},
                           Aabb{{0, 0, 1}, {0.5f, 1, 1}}}) {
    const auto box = grow::clip_to_half(floor.view(), 0, cell);
    ASSERT_TRUE(box);
    EXPECT_EQ(box->lo, (Vec3f{0, 0, 1}));
    EXPECT_EQ(box->hi, (Vec3f{0.5f, 1, least_above(1)}));
  }
}

/// An extent of one float marks a flat box; no other box has it (see is_planar).
TEST(WidenFlat, OneFloatOfExtentMeansFlat) {
  const float next = least_above(1);
  const auto is_flat = [](float lo, float hi) {
    const Aabb box = widen_flat({{lo, 0, 0}, {hi, 1, 1}});
    EXPECT_LE(box.lo.x, lo);
    EXPECT_GE(box.hi.x, hi);
    return kdtree::is_planar({box.lo, 0, box.hi, 1}, 0);
  };
  EXPECT_TRUE(is_flat(1, 1));
  EXPECT_TRUE(is_flat(0, 0));
  EXPECT_TRUE(is_flat(-0.0f, 0));
  EXPECT_FALSE(is_flat(1, next));
  EXPECT_FALSE(is_flat(1, least_above(next)));
  EXPECT_FALSE(is_flat(0, 1e-40f));
  EXPECT_FALSE(is_flat(1e-40f, 1e-40f));  // Lies at a position that no float bound can express
  EXPECT_FALSE(is_flat(-1e-40f, -1e-40f));
}

}  // namespace
}  // namespace sightline::accel::geometry
