// What floats know of points: where they are, and what cannot matter any more.
#include "accel/wide/float_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "accel/wide/float_rays.h"
#include "accel/wide/given_rays.h"
#include "accel/wide/transform.h"
#include "accel/wide/walk.h"
#include "tests/support/random.h"

namespace sightline::accel::wide {
namespace {

/// A packet of points in a tree, and what it refers to.
struct Points {
  GivenRays given;
  BestHits best;
  Packet packet;

  explicit Points(const std::vector<geometry::Ray>& rays) {
    read(rays, given);
    best.clear();
    packet.best = &best;
    packet.points = &given;
    center(given, {0, 0, 0}, (1u << rays.size()) - 1, packet.rays);
  }
};

std::vector<geometry::Ray> random_points(tests::Random& random, double size) {
  std::vector<geometry::Ray> rays;
  for (std::size_t i = 0; i < kLanes; ++i) {
    rays.push_back({.origin = {random.uniform(-size, size), random.uniform(-size, size),
                               random.uniform(-size, size)},
                    .direction = {1, 0, 0}});
  }
  return rays;
}

/// Two floats hold more bits than one: the second is not lost to a compiler that leaves out the
/// first rounding.
TEST(FloatPoints, AreWhereTwoFloatsSayUpToTheirError) {
  tests::Random random(1);
  for (const double size : {1e-6, 1.0, 1e3, 1e9}) {
    for (int round = 0; round < 50; ++round) {
      const auto rays = random_points(random, size);
      Points points(rays);
      const auto most = static_cast<float>(size);
      const Frame frame = frame_of({{-most, -most, 0}, {most, most, most}});
      prepare(points.packet, frame, 0xffff);
      const FloatPoints& near = points.packet.near;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        double squared = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double at = rays[lane].origin[axis] - static_cast<double>(frame.center[axis]);
          const double off = static_cast<double>(near.high[axis][lane]) +
                             static_cast<double>(near.low[axis][lane]) - at;
          squared += off * off;
        }
        EXPECT_LE(std::sqrt(squared), static_cast<double>(near.off[lane]));
        EXPECT_LE(near.off[lane], static_cast<float>(size * 0x1p-40) + 0x1p-59f);
      }
    }
  }
}

TEST(FloatPoints, AreNearABoxUnlessItIsBeyondTheBestDistance) {
  tests::Random random(2);
  std::uint32_t beyond = 0;
  for (int round = 0; round < 500; ++round) {
    const auto rays = random_points(random, 4);
    Points points(rays);
    for (double& t : points.best.t) t = random.uniform(0, 3);
    prepare(points.packet, frame_of({{-1, -1, -1}, {1, 1, 1}}), 0xffff);
    geometry::Aabb box;
    for (int i = 0; i < 2; ++i) {
      box.grow(geometry::Vec3f{static_cast<float>(random.uniform(-1, 1)),
                               static_cast<float>(random.uniform(-1, 1)),
                               static_cast<float>(random.uniform(-1, 1))});
    }
    const std::uint32_t near = meeting(points.packet, box, 0xffff);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      double squared = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double at = rays[lane].origin[axis];
        const double gap = std::max(
            {static_cast<double>(box.lo[axis]) - at, at - static_cast<double>(box.hi[axis]), 0.0});
        squared += gap * gap;
      }
      if (std::sqrt(squared) <= points.best.t[lane]) {
        EXPECT_TRUE((near >> lane & 1) != 0);
      }
      beyond += static_cast<std::uint32_t>(std::sqrt(squared) > 1.001 * points.best.t[lane] &&
                                           (near >> lane & 1) == 0);
    }
  }
  EXPECT_GT(beyond, 1'000u);
}

TEST(FloatPoints, HaveNoLimitWhereFloatsCannotSeeThem) {
  std::vector<geometry::Ray> rays(2, {.origin = {0x1p+100, 0, 0}, .direction = {1, 0, 0}});
  rays[1].origin.x = 3;
  Points points(rays);
  points.best.t.fill(0.5);
  EXPECT_EQ(prepare(points.packet, frame_of({{-1, -1, -1}, {1, 1, 1}}), 3), 1u);
  EXPECT_EQ(points.packet.floats.high[0], std::numeric_limits<float>::infinity());
  EXPECT_EQ(local_limit(points.packet, 0), geometry::kInfinity);
  EXPECT_NEAR(points.packet.floats.high[1], 0.5f, 1e-6f);
}

/// Lengths in a mesh's frame bound those in the scene, also where it is stretched or off.
TEST(FloatPoints, CompareLengthsInBothFrames) {
  tests::Random random(3);
  for (int round = 0; round < 200; ++round) {
    Matrix forth{};
    for (std::size_t i = 0; i < 3; ++i) forth[5 * i] = std::exp2(random.uniform(-6, 6));
    forth[1] = random.uniform(-1, 1);
    forth[3] = random.uniform(-10, 10);
    // The inverse of an upper triangular matrix.
    Matrix back{};
    for (std::size_t i = 0; i < 3; ++i) back[5 * i] = 1 / forth[5 * i];
    back[1] = -forth[1] * back[0] * back[5];
    back[3] = -forth[3] * back[0];
    const auto rays = random_points(random, 20);
    Points points(rays);
    transform(points.given, back, 0xffff, points.packet.rays);
    points.packet.scene_from_local = &forth;
    points.packet.local_from_scene = &back;
    prepare(points.packet, frame_of({{-1, -1, -1}, {1, 1, 1}}), 0xffff);
    const FloatPoints& near = points.packet.near;
    const geometry::Vec3d way = random.direction();
    const auto length_of = [](const Matrix& m, const geometry::Vec3d& v) {
      double squared = 0;
      for (std::size_t row = 0; row < 3; ++row) {
        const double x = m[4 * row] * v.x + m[4 * row + 1] * v.y + m[4 * row + 2] * v.z;
        squared += x * x;
      }
      return std::sqrt(squared);
    };
    EXPECT_LE(length_of(forth, way), near.per_local);
    EXPECT_LE(length_of(back, way), near.per_scene);
    for (const double off : near.scene_off) EXPECT_LT(off, 1e-9);
  }
}

}  // namespace
}  // namespace sightline::accel::wide
