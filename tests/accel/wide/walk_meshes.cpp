#include "tests/accel/wide/walk_meshes.h"

#include <cmath>
#include <cstdint>

#include "tests/support/hard_shapes.h"
#include "tests/support/random.h"

namespace sightline::tests {

using accel::geometry::Vec3f;

namespace {

TestMesh moved(TestMesh mesh, float by) {
  for (Vec3f& v : mesh.vertices) v = {v.x + by, v.y - by, v.z + 2 * by};
  return mesh;
}

/// Pairs of corners that differ by a unit in the last place, and a third far away.
TestMesh needles(std::uint32_t triangles) {
  TestMesh mesh;
  Random random(3);
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const auto x = [&] { return static_cast<float>(random.uniform(-1, 1)); };
    const Vec3f a{x(), x(), x()};
    const auto near = [](float v) { return std::nextafter(v, 2.0f); };
    mesh.vertices.insert(mesh.vertices.end(), {a, {near(a.x), a.y, near(a.z)}, {x(), x(), x()}});
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

}  // namespace

TestMesh scaled(TestMesh mesh, double x, double y, double z) {
  for (Vec3f& v : mesh.vertices) {
    v = {static_cast<float>(static_cast<double>(v.x) * x),
         static_cast<float>(static_cast<double>(v.y) * y),
         static_cast<float>(static_cast<double>(v.z) * z)};
  }
  return mesh;
}

const std::vector<NamedMesh>& walk_meshes() {
  static const std::vector<NamedMesh> all{
      {"triangle", single_triangle},
      {"soup", [] { return random_soup(300, 0.3, 1); }},
      {"dust", [] { return random_soup(500, 1e-6, 2); }},
      {"sheet", [] { return planar_sheet(12); }},
      {"walls", [] { return flat_walls(60); }},
      {"duplicates", [] { return duplicates(60); }},
      {"fan", [] { return fan(64); }},
      {"sphere", [] { return icosphere(2); }},
      {"slivers", [] { return slivers(200, 4); }},
      {"needles", [] { return needles(200); }},
      {"book", [] { return pages_of_book(100, 5); }},
      {"far", [] { return moved(icosphere(2), 1e6f); }},
      {"very_far", [] { return moved(random_soup(300, 0.3, 6), 1e7f); }},
      {"tiny", [] { return scaled(icosphere(2), 0x1p-39, 0x1p-39, 0x1p-39); }},
      {"huge", [] { return scaled(icosphere(2), 0x1p+59, 0x1p+59, 0x1p+59); }},
      {"beam", [] { return scaled(random_soup(300, 0.3, 7), 0x1p+45, 1, 0x1p-20); }},
      {"plate", [] { return scaled(icosphere(2), 1, 0x1p+58, 0x1p+58); }},
      {"subnormal", [] { return scaled(random_soup(300, 0.3, 8), 1, 1, 0x1p-130); }},
  };
  return all;
}

}  // namespace sightline::tests
