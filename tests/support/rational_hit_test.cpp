// The exact reference itself, on cases small enough to be decided by hand.
#include "tests/support/rational_hit.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/random.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

bool hits(const RationalRay& ray, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  return judge(ray, exactly(a), exactly(b), exactly(c)).hit;
}

TEST(Dyadic, IsExactWhereDoublesRound) {
  const Dyadic big(0x1p+250), small(0x1p-1074);
  EXPECT_EQ((big + small - big - small).sign(), 0);
  EXPECT_EQ((big + small - big).sign(), 1);
  EXPECT_EQ((big - small - big).sign(), -1);
  EXPECT_EQ(((big + small) * (big - small) - big * big + small * small).sign(), 0);
  EXPECT_EQ(Dyadic(-0.0).sign(), 0);
  EXPECT_EQ((Dyadic(0.0) - Dyadic(3.0)).rational(), mpq_class(-3));
  EXPECT_EQ((Dyadic(0.75) * Dyadic(-0.5)).rational(), mpq_class(-3, 8));
  EXPECT_EQ(Dyadic(0x1p+80).rational(), mpq_class(mpz_class(1) << 80));
  EXPECT_DOUBLE_EQ(Dyadic::ratio(small, big), 0);
  EXPECT_DOUBLE_EQ(Dyadic::ratio(Dyadic(1.0), Dyadic(3.0)), 1.0 / 3);
}

TEST(Dyadic, AgreesWithRationals) {
  Random random(41);
  const auto number = [&] {
    return std::ldexp(random.uniform(-1, 1), static_cast<int>(random.below(600)) - 300);
  };
  for (int round = 0; round < 2000; ++round) {
    const double a = number(), b = number(), c = round % 7 == 0 ? 0 : number();
    const Dyadic x = Dyadic(a) * Dyadic(b) - Dyadic(c) * Dyadic(a) + Dyadic(b);
    ASSERT_EQ(x.rational(),
              mpq_class(a) * mpq_class(b) - mpq_class(c) * mpq_class(a) + mpq_class(b));
  }
}

TEST(RationalRay, SidesAreSigned) {
  const RationalRay down({0.25, 0.25, 5}, {0, 0, -1});
  const DyadicVec p = exactly(Vec3f{0, 0, 0}), q = exactly(Vec3f{1, 0, 0});
  EXPECT_EQ(down.side(p, q), -1);
  EXPECT_EQ(down.side(q, p), 1);
  EXPECT_EQ(RationalRay({0.5, 0, 5}, {0, 0, -1}).side(p, q), 0);
  // One part in 2^1074 beside the edge.
  const double least = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(RationalRay({0.5, least, 5}, {0, 0, -1}).side(p, q), -1);
  EXPECT_EQ(RationalRay({0.5, -least, 5}, {0, 0, -1}).side(p, q), 1);
}

/// The origin is moved to (e, e^2, e^3): first toward x, then much less toward y.
TEST(RationalHit, ZerosAreDecidedByTheMovedOrigin) {
  const RationalRay down({0, 0, 5}, {0, 0, -1});
  // An edge along y through the line belongs to the triangle on the side of positive x.
  EXPECT_TRUE(hits(down, {0, -1, 0}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_FALSE(hits(down, {0, -1, 0}, {-1, 0, 0}, {0, 1, 0}));
  // An edge along x: to the one on the side of positive y.
  EXPECT_TRUE(hits(down, {-1, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_FALSE(hits(down, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}));
  // A vertex: e dominates e^2, so the owner contains the points next to it toward x, above the
  // axis.
  EXPECT_TRUE(hits(down, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}));
  EXPECT_FALSE(hits(down, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}));
  EXPECT_FALSE(hits(down, {0, 0, 0}, {1, 0, 0}, {1, -1, 0}));
  // Seen along x, only y and z matter.
  const RationalRay along_x({-5, 0, 0}, {1, 0, 0});
  EXPECT_TRUE(hits(along_x, {0, 0, 0}, {0, 1, 0}, {0, 1, 1}));
  EXPECT_FALSE(hits(along_x, {0, 0, 0}, {0, 1, 1}, {0, 0, 1}));
}

TEST(RationalHit, CountsZerosAndRefusesEdgeOnTriangles) {
  const RationalRay down({0, 0, 5}, {0, 0, -1});
  const auto zeros = [&](const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const RationalHit verdict = judge(down, exactly(a), exactly(b), exactly(c));
    EXPECT_FALSE(verdict.hit);
    return verdict.zeros;
  };
  EXPECT_EQ(zeros({-1, 0, 0}, {1, 0, 0}, {0, 0, 3}), 3);  // The line lies in the triangle's plane
  EXPECT_EQ(zeros({1, 0, 0}, {1, 0, 2}, {2, 0, 0}), 3);
  EXPECT_EQ(zeros({1, 1, 0}, {1, 1, 2}, {2, 1, 0}), 1);  // One edge is parallel to the line
  EXPECT_EQ(zeros({0, 0, 0}, {0, 0, 0}, {0, 0, 0}), 3);
}

TEST(RationalMeeting, IsExact) {
  const RationalRay ray({0, 0, 1}, {0, 0, -3});
  const DyadicVec a = exactly(Vec3f{-1, -1, 0}), b = exactly(Vec3f{1, -1, 0}),
                  c = exactly(Vec3f{0, 2, 0});
  const RationalMeeting meeting(ray, a, b, c);
  EXPECT_EQ(meeting.t(), mpq_class(1, 3));
  EXPECT_LT(meeting.t_error(1.0 / 3), 0x1p-54);
  EXPECT_GT(meeting.t_error(1.0 / 3), 0);
  EXPECT_DOUBLE_EQ(meeting.t_error(1.0), 1.0 / 3);  // Off by 2/3; the farthest v - o has length 2
  EXPECT_LT(meeting.point_error(1.0 / 3, 1.0 / 3), 0x1p-53);
  EXPECT_DOUBLE_EQ(meeting.point_error(0, 0), 0.5);
}

}  // namespace
}  // namespace sightline::tests
