// Building blocks of hard shapes.
#pragma once

#include <cmath>
#include <cstdint>

#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

inline void add_triangle(TestMesh& mesh, const accel::geometry::Vec3d& a,
                         const accel::geometry::Vec3d& b, const accel::geometry::Vec3d& c) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {accel::geometry::Vec3f(a), accel::geometry::Vec3f(b),
                                             accel::geometry::Vec3f(c)});
  mesh.faces.push_back({first, first + 1, first + 2});
}

/// A lattice over the parallelogram at `corner`, exactly `triangles` faces, row by row.
/// `displace(point, i, j)` moves a lattice point.
template <class Displace>
void add_lattice(TestMesh& mesh, std::uint32_t triangles, const accel::geometry::Vec3d& corner,
                 const accel::geometry::Vec3d& u, const accel::geometry::Vec3d& v,
                 const Displace& displace) {
  const std::uint32_t quads = (triangles + 1) / 2;
  if (quads == 0) return;
  const auto columns = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(quads)));
  const std::uint32_t rows = (quads + columns - 1) / columns;
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::uint32_t j = 0; j <= rows; ++j) {
    for (std::uint32_t i = 0; i <= columns; ++i) {
      const accel::geometry::Vec3d p =
          corner + u * (static_cast<double>(i) / columns) + v * (static_cast<double>(j) / rows);
      mesh.vertices.push_back(accel::geometry::Vec3f(displace(p, i, j)));
    }
  }
  const std::size_t end = mesh.faces.size() + triangles;
  for (std::uint32_t quad = 0; quad < quads; ++quad) {
    const std::uint32_t a = first + quad / columns * (columns + 1) + quad % columns;
    const std::uint32_t above = a + columns + 1;
    mesh.faces.push_back({a, a + 1, above + 1});
    if (mesh.faces.size() < end) mesh.faces.push_back({a, above + 1, above});
  }
}

inline void add_lattice(TestMesh& mesh, std::uint32_t triangles,
                        const accel::geometry::Vec3d& corner, const accel::geometry::Vec3d& u,
                        const accel::geometry::Vec3d& v) {
  add_lattice(mesh, triangles, corner, u, v,
              [](const accel::geometry::Vec3d& p, std::uint32_t, std::uint32_t) { return p; });
}

/// Triangles small enough not to touch, in the cube of this width at `corner`.
inline void add_scattered(TestMesh& mesh, std::uint32_t triangles,
                          const accel::geometry::Vec3d& corner, double width, Random& random) {
  const double size = 0.5 * width / std::cbrt(1.0 + triangles);
  const auto point = [&](double extent) {
    return accel::geometry::Vec3d{random.uniform() * extent, random.uniform() * extent,
                                  random.uniform() * extent};
  };
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const accel::geometry::Vec3d at = corner + point(width - size);
    add_triangle(mesh, at + point(size), at + point(size), at + point(size));
  }
}

}  // namespace sightline::tests
