// Small meshes whose answers are known in closed form, and random ones.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::tests {

struct TestMesh {
  std::vector<accel::geometry::Vec3f> vertices;
  std::vector<accel::geometry::Face> faces;

  accel::geometry::MeshView view() const { return {vertices, faces}; }
  /// Appends the other mesh's triangles.
  void append(const TestMesh& other);
};

/// (0,0,0) (1,0,0) (0,1,0): a ray along -z from (x, y, 1) hits at t = 1, u = x, v = y if x + y < 1.
TestMesh single_triangle();

/// [lo, hi] on each axis, 12 outward triangles; faces 2k and 2k+1 are side k of -x +x -y +y -z +z.
TestMesh cube(float lo = -1, float hi = 1);
TestMesh box(const accel::geometry::Vec3f& lo, const accel::geometry::Vec3f& hi);

/// `steps` treads and risers of unit width in y (0..1): tread i is z = i for x in [i, i + 1], faces
/// 4i and 4i+1; its riser is x = i + 1 for z in [i, i + 1], faces 4i+2 and 4i+3.
TestMesh staircase(std::uint32_t steps);

/// n x n quads of unit size in the plane z = 0 over [0, n]^2. The quad (x, y) consists of faces 2(y
/// n + x) and the next one, below and above its diagonal from (x, y) to (x + 1, y + 1).
TestMesh planar_sheet(std::uint32_t n);

/// `count` flat walls x = 0, 1, 2, ..., each of two triangles over [0, 1]^2 in y, z: the nearest
/// along +x from x = -0.5 is wall 0 at t = 0.5, from x = i + 0.5 it is wall i + 1.
TestMesh flat_walls(std::uint32_t count);

/// The same triangle `count` times: the hit is the least face.
TestMesh duplicates(std::uint32_t count);

/// `blades` triangles around (0,0,0) in the plane z = 0 that form a regular polygon of radius 1.
/// `blades` is a power of two, at least 4.
TestMesh fan(std::uint32_t blades);

/// Triangles with corners about `size` around centers uniform in [0, 1]^3.
TestMesh random_soup(std::uint32_t triangles, double size, std::uint64_t seed);

/// 20 * 4^level triangles on the unit sphere, facing outward.
TestMesh icosphere(int level);

/// Corners of a regular polygon on the unit circle, from (1, 0) counterclockwise. `corners` is a
/// power of two, at least 4.
std::vector<std::pair<double, double>> unit_circle(std::uint32_t corners);

/// Rays from a sphere around the mesh, whose diameter is three diagonals of the box, toward uniform
/// points of the box.
std::vector<accel::geometry::Ray> rays_at(const TestMesh& mesh, std::size_t count,
                                          std::uint64_t seed);

}  // namespace sightline::tests
