// Hard shapes whose triangles have overlapping boxes.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/hard_parts.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

namespace {

void add_needle(TestMesh& mesh, const Vec3d& from, const Vec3d& to, double width, Random& random) {
  add_triangle(mesh, from, to, (from + to) * 0.5 + random.direction() * width);
}

Vec3d point_in_cube(Random& random) {
  const double x = random.uniform(), y = random.uniform();
  return {x, y, random.uniform()};
}

}  // namespace

TestMesh slivers(std::uint32_t triangles, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const Vec3d middle = point_in_cube(random), half = random.direction() * 0.5;
    add_needle(mesh, middle - half, middle + half, 1e-4, random);
  }
  return mesh;
}

TestMesh tilted_rods(std::uint32_t triangles, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  const double width = 0.2 / std::sqrt(1.0 + triangles);
  for (std::uint32_t i = 0; i < triangles; ++i) {
    Vec3d from = point_in_cube(random);
    from.x = 0;
    add_needle(mesh, from, from + Vec3d{1, 0.1, 0.15}, width, random);
  }
  return mesh;
}

TestMesh fan_about_vertex(std::uint32_t triangles, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  std::uint32_t corners = 4;
  while (corners < triangles) corners *= 2;
  mesh.vertices.push_back({0, 0, 0});
  for (const auto& [x, y] : unit_circle(corners)) {
    mesh.vertices.push_back(Vec3f(Vec3d{x, y, random.uniform(-0.05, 0.05)}));
  }
  for (std::uint32_t i = 0; i < triangles; ++i) {
    // Over the whole circle; the number of corners is a power of two.
    const auto at = static_cast<std::uint32_t>(std::uint64_t{i} * corners / triangles);
    mesh.faces.push_back({0, 1 + at, 1 + (at + 1) % corners});
  }
  return mesh;
}

TestMesh pages_of_book(std::uint32_t triangles, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  mesh.vertices = {{0, 0, 0}, {1, 1, 1}};
  for (std::uint32_t i = 0; i < triangles; ++i) {
    mesh.faces.push_back({0, 1, static_cast<std::uint32_t>(mesh.vertices.size())});
    const Vec3d side = Vec3d{0.5, 0.5, 0.5} + random.direction() * 0.5;
    mesh.vertices.push_back(Vec3f(side));
  }
  return mesh;
}

TestMesh stacked_hills(std::uint32_t triangles, std::uint64_t seed) {
  constexpr std::uint32_t kCopies = 100;
  TestMesh mesh = hills((triangles + kCopies - 1) / kCopies, seed);
  const std::vector<accel::geometry::Face> once = mesh.faces;
  while (mesh.faces.size() < triangles) {
    mesh.faces.push_back(once[mesh.faces.size() % once.size()]);
  }
  mesh.faces.resize(triangles);
  return mesh;
}

TestMesh turned_halls(std::uint32_t triangles) {
  // A hall: floor, ceiling and two walls, and eight columns of one box each.
  constexpr std::uint32_t kPerHall = (4 + 8) * 12;
  const std::uint32_t count = triangles / kPerHall;
  const auto side = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  TestMesh mesh;
  const auto add_box = [&](double x, double y, double z, double wide, double high, double deep) {
    mesh.append(box(Vec3f(Vec3d{x, y, z}), Vec3f(Vec3d{x + wide, y + high, z + deep})));
  };
  for (std::uint32_t hall = 0; hall < count; ++hall) {
    const double x = hall % side * 22.0, z = hall / side * 12.0;
    add_box(x, -0.2, z, 20, 0.2, 10);
    add_box(x, 6, z, 20, 0.2, 10);
    add_box(x, 0, z - 0.3, 20, 6, 0.3);
    add_box(x, 0, z + 10, 20, 6, 0.3);
    for (std::uint32_t column = 0; column < 8; ++column) {
      add_box(x + 2 + column % 4 * 5, 0, column < 4 ? z + 2 : z + 8, 0.5, 6, 0.5);
    }
  }
  constexpr double kTurn = 1 / std::numbers::sqrt2;
  for (Vec3f& v : mesh.vertices) {
    Vec3d p(v);
    p = {p.x, (p.y - p.z) * kTurn, (p.y + p.z) * kTurn};
    p = {(p.x + p.z) * kTurn, p.y, (p.z - p.x) * kTurn};
    p = {(p.x - p.y) * kTurn, (p.x + p.y) * kTurn, p.z};
    v = Vec3f(p);
  }
  return mesh;
}

TestMesh large_over_small(std::uint32_t triangles, std::uint64_t seed) {
  TestMesh mesh = hills(triangles - triangles / 100, seed);
  Random random(seed);
  for (std::uint32_t i = 0; i < triangles / 100; ++i) {
    const double y = random.uniform(0, 0.5);
    add_triangle(mesh, {-0.5, y, -0.5}, {1.5, y + 0.1 * random.uniform(), 0},
                 {0, y + 0.1 * random.uniform(), 1.5});
  }
  return mesh;
}

}  // namespace sightline::tests
