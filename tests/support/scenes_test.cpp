// The shared scenes have their documented properties, and are the same everywhere.
#include "tests/support/scenes.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/random.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;

// Each edge of a closed surface appears once in each direction.
bool is_closed(const TestMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const accel::geometry::Face& f : mesh.faces) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{f[i], f[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (count != 1 || back == edges.end() || back->second != 1) return false;
  }
  return true;
}

double volume(const TestMesh& mesh) {
  double six = 0;
  for (const accel::geometry::Face& f : mesh.faces) {
    const Vec3d a(mesh.vertices[f[0]]), b(mesh.vertices[f[1]]), c(mesh.vertices[f[2]]);
    six += dot(a, cross(b, c));
  }
  return six / 6;
}

TEST(Scenes, CubeAndSpheresAreClosedAndOutward) {
  EXPECT_TRUE(is_closed(cube()));
  EXPECT_DOUBLE_EQ(volume(cube()), 8);
  for (int level = 0; level < 4; ++level) {
    const TestMesh sphere = icosphere(level);
    EXPECT_EQ(sphere.faces.size(), 20u << (2 * level));
    EXPECT_EQ(sphere.vertices.size(), sphere.faces.size() / 2 + 2);
    EXPECT_TRUE(is_closed(sphere));
    EXPECT_GT(volume(sphere), 2.5);
  }
}

TEST(Scenes, HaveTheRequestedCounts) {
  EXPECT_EQ(staircase(7).faces.size(), 28u);
  EXPECT_EQ(planar_sheet(5).faces.size(), 50u);
  EXPECT_EQ(flat_walls(4).faces.size(), 8u);
  EXPECT_EQ(duplicates(9).faces.size(), 9u);
  EXPECT_EQ(fan(16).faces.size(), 16u);
  EXPECT_EQ(random_soup(11, 0.1, 1).faces.size(), 11u);
}

TEST(Scenes, CircleIsClosed) {
  const auto circle = unit_circle(64);
  ASSERT_EQ(circle.size(), 64u);
  EXPECT_NEAR(circle[16].first, 0, 1e-14);
  EXPECT_NEAR(circle[16].second, 1, 1e-14);
  EXPECT_NEAR(circle[48].second, -1, 1e-14);
}

// Fixed numbers: a change of the generator would silently change every measurement.
TEST(Random, GivesTheSameNumbersEverywhere) {
  Random random(0);
  EXPECT_EQ(random.next(), 0xe220a8397b1dcdafu);
  EXPECT_EQ(random.next(), 0x6e789e6aa1b965f4u);
  Random other(42);
  for (int i = 0; i < 1000; ++i) {
    const double x = other.uniform();
    EXPECT_GE(x, 0);
    EXPECT_LT(x, 1);
    EXPECT_NEAR(length(other.direction()), 1, 1e-15);
    EXPECT_LT(other.below(7), 7u);
  }
}

TEST(Random, StreamsDiffer) {
  EXPECT_NE(Random(1, 0).next(), Random(1, 1).next());
  EXPECT_NE(Random(1, 5).next(), Random(2, 5).next());
  EXPECT_EQ(Random(3, 9).next(), Random(3, 9).next());
}

}  // namespace
}  // namespace sightline::tests
