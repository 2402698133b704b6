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
using geometry::Vec3d;

Vec3d linear(const Matrix& m, const Vec3d& v) {
  const auto row = [&](std::size_t i) {
    return m[4 * i] * v.x + m[4 * i + 1] * v.y + m[4 * i + 2] * v.z;
  };
  return {row(0), row(1), row(2)};
}
double length_of(const Vec3d& v) { return std::sqrt(dot(v, v)); }

/// What floats make of a vector of the mesh's frame, without their roundings.
Vec3d stretched(const FloatPoints& near, const Vec3d& v) {
  if (!near.stretched) return v;
  Matrix m{};
  for (std::size_t i = 0; i < 3; ++i) m[i] = static_cast<double>(near.metric[i]);
  for (std::size_t i = 0; i < 2; ++i) m[5 + i] = static_cast<double>(near.metric[3 + i]);
  m[10] = static_cast<double>(near.metric[5]);
  return linear(m, v);
}

/// Points in a mesh that its node stretches along the axes by up to 2^`uneven`, and shears.
struct Stretched {
  Matrix forth{}, back{};
  std::vector<geometry::Ray> rays;
  Points points;
  Frame frame = frame_of({{-1, -1, -1}, {1, 1, 1}});

  Stretched(tests::Random& random, double uneven) : rays(random_points(random, 20)), points(rays) {
    for (std::size_t i = 0; i < 3; ++i) forth[5 * i] = std::exp2(random.uniform(-uneven, uneven));
    forth[1] = random.uniform(-1, 1);
    forth[3] = random.uniform(-10, 10);
    // The inverse of an upper triangular matrix.
    for (std::size_t i = 0; i < 3; ++i) back[5 * i] = 1 / forth[5 * i];
    back[1] = -forth[1] * back[0] * back[5];
    back[3] = -forth[3] * back[0];
    transform(points.given, back, 0xffff, points.packet.rays);
    points.packet.scene_from_local = &forth;
    points.packet.local_from_scene = &back;
    prepare(points.packet, frame, 0xffff);
  }
};

TEST(FloatPoints, CompareLengthsInBothFrames) {
  tests::Random random(3);
  int stretches = 0;
  for (int round = 0; round < 400; ++round) {
    const Stretched mesh(random, round % 2 == 0 ? 2 : 8);
    const FloatPoints& near = mesh.points.packet.near;
    const Vec3d way = random.direction();
    const double in_scene = length_of(linear(mesh.forth, way)),
                 in_frame = length_of(stretched(near, way));
    EXPECT_LE(in_scene, in_frame * near.per_local);
    EXPECT_LE(in_frame, in_scene * near.per_scene);
    EXPECT_LE(in_frame, 1 + 1e-6);
    EXPECT_LE(1, in_scene * near.mesh_per_scene);
    for (const double off : near.scene_off) EXPECT_LT(off, 1e-9);
    if (!near.stretched) continue;
    ++stretches;
    EXPECT_LT(near.per_local * near.per_scene, 1 + 1e-3) << "as long as in the scene";
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      Vec3d at, seen;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        at[axis] = mesh.points.packet.rays.origin[axis][lane] -
                   static_cast<double>(mesh.frame.center[axis]);
        seen[axis] =
            static_cast<double>(near.high[axis][lane]) + static_cast<double>(near.low[axis][lane]);
      }
      at = at * static_cast<double>(mesh.frame.scale);
      EXPECT_LE(length_of(stretched(near, at) - seen), near.off[lane]);
    }
  }
  EXPECT_GT(stretches, 200);
}

/// A box that holds a point of the mesh at the distance of the best face is not left out.
TEST(FloatPoints, MeetBoxesThatAreStretched) {
  tests::Random random(4);
  int left_out = 0;
  for (int round = 0; round < 400; ++round) {
    Stretched mesh(random, 4);
    Packet& packet = mesh.points.packet;
    geometry::Aabb box;
    Vec3d inside;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto one = static_cast<float>(random.uniform(-1, 1)),
                 other = static_cast<float>(random.uniform(-1, 1));
      box.lo[axis] = std::min(one, other);
      box.hi[axis] = std::max(one, other);
      // In the frame of the tree; its corners are as good as any.
      inside[axis] = static_cast<double>(round % 3 == 0 ? box.lo[axis] : box.hi[axis]);
    }
    const Vec3d local =
        inside * (1 / static_cast<double>(mesh.frame.scale)) + Vec3d(mesh.frame.center);
    const Vec3d at =
        linear(mesh.forth, local) + Vec3d{mesh.forth[3], mesh.forth[7], mesh.forth[11]};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      mesh.points.best.t[lane] = length_of(at - scene_point(packet, lane)) * (1 + 0x1p-50);
      tighten_point(packet, lane);
    }
    EXPECT_EQ(near_box(packet, box, 0xffff), 0xffffu);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      mesh.points.best.t[lane] *= 0.25;
      tighten_point(packet, lane);
    }
    left_out += near_box(packet, box, 0xffff) != 0xffff ? 1 : 0;
  }
  EXPECT_GT(left_out, 300) << "but others are";
}

}  // namespace
}  // namespace sightline::accel::wide
