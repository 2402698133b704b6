// Rays in split planes, from points on them, along all axes and diagonals of a lattice.
#include <gtest/gtest.h>

#include <vector>

#include "accel/published/any_builder.h"
#include "tests/accel/stability/asked_tree.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {
namespace {

using accel::geometry::Ray;
using accel::geometry::Vec3d;

/// -1, -0, 0 and 1 on every axis, without zero vectors: the 26 directions to neighbors, with zeros
/// of both signs.
std::vector<Vec3d> lattice_directions() {
  std::vector<Vec3d> directions;
  for (const double x : {-1.0, -0.0, 0.0, 1.0}) {
    for (const double y : {-1.0, -0.0, 0.0, 1.0}) {
      for (const double z : {-1.0, -0.0, 0.0, 1.0}) {
        if (x != 0 || y != 0 || z != 0) directions.push_back({x, y, z});
      }
    }
  }
  return directions;
}

/// A lattice of n unit cubes along each axis, with all walls between them.
TestMesh honeycomb(std::uint32_t n) {
  TestMesh mesh;
  for (std::uint32_t x = 0; x < n; ++x) {
    for (std::uint32_t y = 0; y < n; ++y) {
      for (std::uint32_t z = 0; z < n; ++z) {
        const auto at = [](std::uint32_t i) { return static_cast<float>(i); };
        mesh.append(box({at(x), at(y), at(z)}, {at(x + 1), at(y + 1), at(z + 1)}));
      }
    }
  }
  return mesh;
}

TEST(RaysInPlanes, FromEveryPointOfALatticeInEveryDirection) {
  const TestMesh mesh = honeycomb(2);
  std::vector<Ray> rays;
  for (double x = -1; x <= 3; x += 0.5) {
    for (double y = -1; y <= 3; y += 1) {
      for (const double z : {-1.0, 0.0, 0.5, 1.0, 2.0}) {
        for (const Vec3d& direction : lattice_directions()) rays.push_back({{x, y, z}, direction});
      }
    }
  }
  expect_right(mesh, rays);
}

TEST(RaysInPlanes, AlongTheLinesOfAGrid) {
  const TestMesh mesh = planar_sheet(8);
  std::vector<Ray> rays;
  for (double x = 0; x <= 8; x += 0.5) {
    // In the sheet's own plane nothing is hit; straight down between lines and onto them; and
    // slanted along a line, so that the ray stays in a plane that splits the sheet.
    for (const Vec3d& direction : lattice_directions()) {
      rays.push_back({{x, -1, 0}, direction});
      rays.push_back({{x, 4, 2}, direction});
      rays.push_back({{x, 4, 2}, {direction.x, direction.y * 0.5, -1}});
    }
  }
  expect_right(mesh, rays);
}

}  // namespace
}  // namespace sightline::tests
