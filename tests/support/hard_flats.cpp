// Hard shapes of flat axis-aligned triangles.
#include <algorithm>
#include <numbers>

#include "tests/support/hard_parts.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

TestMesh walls_among_scattered(std::uint32_t triangles, std::uint32_t walls, std::uint64_t seed) {
  constexpr double kOffsets[] = {1 / std::numbers::phi, 1 / std::numbers::pi};
  TestMesh mesh;
  Random random(seed);
  for (std::uint32_t wall = 0; wall < walls; ++wall) {
    const double x = kOffsets[wall % std::size(kOffsets)];
    add_lattice(mesh, triangles / 2 / walls, {x, 0, 0}, {0, 1, 0}, {0, 0, 1});
  }
  const auto rest = triangles - static_cast<std::uint32_t>(mesh.faces.size());
  add_scattered(mesh, rest, {0, 0, 0}, 1, random);
  return mesh;
}

TestMesh sheet(std::uint32_t triangles) {
  TestMesh mesh;
  add_lattice(mesh, triangles, {0, 1 / std::numbers::pi, 0}, {1, 0, 0}, {0, 0, 1});
  return mesh;
}

TestMesh tiled_cube(std::uint32_t triangles) {
  TestMesh mesh;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3d u{}, v{};
    u[(axis + 1) % 3] = 1;
    v[(axis + 2) % 3] = 1;
    for (const double at : {0.0, 1.0}) {
      Vec3d corner{};
      corner[axis] = at;
      const auto side = static_cast<std::uint32_t>(2 * axis + (at > 0 ? 1 : 0));
      add_lattice(mesh, triangles / 6 + (side < triangles % 6 ? 1 : 0), corner, u, v);
    }
  }
  return mesh;
}

TestMesh rooms(std::uint32_t triangles, std::uint64_t seed) {
  constexpr double kShare = 0.7;
  // With k cells an axis there are 3 k k (k + 1) quads. An odd number: with 2^k cells every middle
  // would be a wall, which makes median cuts look better than they are.
  std::uint32_t cells = 1;
  const auto expected = [](double k) { return kShare * 6 * k * k * (k + 1); };
  while (expected(cells + 2) <= triangles) cells += 2;
  TestMesh mesh;
  Random random(seed);
  const double width = 1.0 / cells;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3d u{}, v{};
    u[(axis + 1) % 3] = width;
    v[(axis + 2) % 3] = width;
    for (std::uint32_t plane = 0; plane <= cells; ++plane) {
      for (std::uint32_t quad = 0; quad < cells * cells; ++quad) {
        if (random.uniform() >= kShare || mesh.faces.size() + 2 > triangles) continue;
        Vec3d corner{};
        corner[axis] = plane * width;
        corner[(axis + 1) % 3] = quad % cells * width;
        corner[(axis + 2) % 3] = quad / cells * width;
        add_lattice(mesh, 2, corner, u, v);
      }
    }
  }
  return mesh;
}

TestMesh furnished_rooms(std::uint32_t triangles) {
  constexpr std::uint32_t kPerCell = 17 * 12;
  const std::uint32_t count = triangles / kPerCell;
  const auto side = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  TestMesh mesh;
  for (std::uint32_t cell = 0; cell < count; ++cell) {
    const double x = cell % side * 10.0, z = cell / side * 10.0;
    mesh.append(box(Vec3f(Vec3d{x, 0, z}), Vec3f(Vec3d{x + 10, 3, z + 10})));
    for (std::uint32_t i = 0; i < 16; ++i) {
      const double left = x + 1 + i % 4 * 2.25, front = z + 1 + i / 4 * 2.25;
      mesh.append(box(Vec3f(Vec3d{left, 0, front}), Vec3f(Vec3d{left + 1, 0.75, front + 1})));
    }
  }
  return mesh;
}

}  // namespace sightline::tests
