// The rule of rounding: what it leaves alone, what it shares, and how fine it is.
#include "client/importer/lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/random.h"

namespace sightline::client::importer {
namespace {

VertexBox cube(const Point& corner, double size) {
  VertexBox box;
  box.add(corner);
  box.add({corner[0] + size, corner[1] + size, corner[2] + size});
  return box;
}

LatticeStep step_of(const VertexBox& box) { return {box.size(), box.reach()}; }

bool is_float(double x) { return static_cast<double>(static_cast<float>(x)) == x; }

TEST(Lattice, MeshesOfManySizesHaveOneStep) {
  for (const double size : {1.3, 13.0, 100.0, 999.9, 4096.0})
    EXPECT_EQ(step_of(cube({4e6, 5e5, 100}, size)).value(), 4096) << size;
  EXPECT_EQ(step_of(cube({4e6, 5e5, 100}, 4097)).value(), 65536);
  EXPECT_LT(step_of(cube({4e6, 5e5, 100}, 1)).value(), 4096);
  EXPECT_EQ(step_of(cube({-9e6, 0, 0}, 100)).value(), 4096);
}

TEST(Lattice, ScalingByPowersOfSixteenScalesTheStep) {
  for (const int exponent : {-200, -4, 4, 60}) {
    const double scale = std::ldexp(1.0, exponent);
    EXPECT_EQ(step_of(cube({4e6 * scale, 0, 0}, 100 * scale)).value(), 4096 * scale);
  }
}

TEST(Lattice, FloatsDoNotChange) {
  tests::Random random(1);
  for (int round = 0; round < 20'000; ++round) {
    const double size = std::exp2(random.uniform(-40, 40));
    const double far = size * std::exp2(random.uniform(-5, 40));
    const LatticeStep step(size, {far, far / 3, 1});
    const auto x = static_cast<double>(static_cast<float>(far * random.uniform(-1, 1)));
    ASSERT_EQ(step.rounded(x), x);
  }
}

TEST(Lattice, TheRestOfARoundedCoordinateIsAFloat) {
  tests::Random random(2);
  for (int round = 0; round < 5'000; ++round) {
    const double size = std::exp2(random.uniform(-20, 20));
    const Point corner{size * std::exp2(random.uniform(-3, 35)),
                       -size * std::exp2(random.uniform(0, 9)), size * random.uniform(-1, 1)};
    const VertexBox box = cube(corner, size);
    const LatticeStep step = step_of(box);
    const Point offset = step.offset(box);
    for (int i = 0; i < 20; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double x = random.uniform(box.lo[k], box.hi[k]);
        const double rounded = step.rounded(x), rest = rounded - offset[k];
        ASSERT_TRUE(is_float(rest)) << x << " of " << size;
        ASSERT_EQ(rest + offset[k], rounded);
        ASSERT_LE(std::abs(rounded - x), step.error({x, -x, 0}));
        ASSERT_LE(std::abs(rounded - x), 2e-4 * size);
      }
    }
  }
}

TEST(Lattice, RoundsHalvesToEvenMultiples) {
  const LatticeStep step(1000, {4e6, 0, 0});
  const double quantum = 4096 * 0x1p-24;
  EXPECT_EQ(step.rounded(4e6 + 0.5 * quantum), 4e6);
  EXPECT_EQ(step.rounded(4e6 + 1.5 * quantum), 4e6 + 2 * quantum);
  EXPECT_EQ(step.rounded(-4e6 - 0.5 * quantum), -4e6);
  EXPECT_EQ(step.rounded(0.1), static_cast<double>(0.1F));
}

TEST(Lattice, WithoutASizeCoordinatesBecomeFloats) {
  for (const double size : {0.0, -1.0, std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::quiet_NaN()}) {
    const LatticeStep step(size, {4e6, 0, 0});
    EXPECT_EQ(step.rounded(4e6 + 0.1), 4e6);
    EXPECT_EQ(step.offset(cube({4e6, 0, 0}, 1)), (Point{}));
  }
  const LatticeStep tiny(1e-320, {1e-310, 0, 0});
  EXPECT_EQ(tiny.rounded(1e-310), 0);
  const LatticeStep huge(1e-300, {1e300, 0, 0});
  EXPECT_EQ(huge.rounded(1e300), 1e300);
}

TEST(Lattice, BoxesHoldFiniteVerticesThatFacesName) {
  FileMesh mesh;
  mesh.vertices = {{1, 2, 3}, {4, 0, 9}, {NAN, 50, 50}, {-70, 0, 0}};
  EXPECT_EQ(box_of(mesh).lo, (Point{-70, 0, 0}));
  mesh.faces = {{0, 3}, {0, 1, 2}};
  EXPECT_EQ(box_of(mesh).lo, (Point{1, 0, 3}));
  EXPECT_EQ(box_of(mesh).hi, (Point{4, 2, 9}));
  EXPECT_EQ(box_of(mesh).reach(), (Point{4, 2, 9}));
  EXPECT_EQ(box_of(mesh).size(), 6);
  EXPECT_LT(box_of(FileMesh()).size(), 0);
}

}  // namespace
}  // namespace sightline::client::importer
