// Hard shapes with unusual arrays.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/hard_parts.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {

using accel::geometry::Face;

TestMesh interleaved(std::uint32_t triangles, std::uint64_t seed) {
  const auto period =
      std::max(2u, static_cast<std::uint32_t>(std::log10(std::max(1.0, 1.0 * triangles))));
  TestMesh floor;
  add_lattice(floor, triangles / period, {-5, 0, -5}, {10, 0, 0}, {0, 0, 10});
  const auto rest = triangles - static_cast<std::uint32_t>(floor.faces.size());
  TestMesh mesh = ball(rest, {4, 0.6, 4}, 0.5, 0.3, seed);
  const std::vector<Face> object = mesh.faces;
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), floor.vertices.begin(), floor.vertices.end());
  mesh.faces.clear();
  auto next = object.begin();
  for (const Face& f : floor.faces) {
    mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    for (std::uint32_t i = 1; i < period && next != object.end(); ++i) {
      mesh.faces.push_back(*next++);
    }
  }
  mesh.faces.insert(mesh.faces.end(), next, object.end());
  return mesh;
}

TestMesh with_nonfinite(std::uint32_t triangles, std::uint64_t seed) {
  constexpr float kOdd[] = {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()};
  TestMesh mesh = ball(triangles, {0, 0, 0}, 1, 0.3, seed);
  Random random(seed);
  for (std::size_t i = 0; i < mesh.vertices.size() / 500; ++i) {
    mesh.vertices[random.below(mesh.vertices.size())][random.below(3)] = kOdd[i % 3];
  }
  return mesh;
}

TestMesh with_zero_area(std::uint32_t triangles, std::uint64_t seed) {
  TestMesh mesh = hills(triangles, seed);
  Random random(seed);
  for (std::size_t i = 0; i < mesh.faces.size() / 100; ++i) {
    Face& face = mesh.faces[random.below(mesh.faces.size())];
    switch (i % 3) {
      case 0:
        face = {face[0], face[0], face[0]};
        break;
      case 1:
        face = {face[0], face[1], face[0]};
        break;
      default: {  // The midpoint of two corners, distinct from both in float
        const accel::geometry::Vec3d middle = (accel::geometry::Vec3d(mesh.vertices[face[0]]) +
                                               accel::geometry::Vec3d(mesh.vertices[face[1]])) *
                                              0.5;
        face[2] = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(accel::geometry::Vec3f(middle));
      }
    }
  }
  return mesh;
}

}  // namespace sightline::tests
