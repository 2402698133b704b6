// Small meshes whose answers are known in closed form, and random ones.
#include "tests/support/scenes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "accel/geometry/aabb.h"
#include "tests/support/random.h"

namespace sightline::tests {

using accel::geometry::Face;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

namespace {

void add_quad(TestMesh& mesh, const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c, d});
  mesh.faces.push_back({first, first + 1, first + 2});
  mesh.faces.push_back({first, first + 2, first + 3});
}

TestMesh icosahedron() {
  const double phi = (1 + std::sqrt(5.0)) / 2;
  TestMesh mesh;
  for (int i = 0; i < 3; ++i) {
    for (const double one : {-1.0, 1.0}) {
      for (const double far : {-phi, phi}) {
        Vec3d p;
        p[static_cast<std::size_t>(i)] = one;
        p[static_cast<std::size_t>((i + 1) % 3)] = far;
        mesh.vertices.push_back(Vec3f(p * (1 / std::sqrt(1 + phi * phi))));
      }
    }
  }
  // The twenty faces are the triples of vertices at edge distance from each other, facing outward.
  const auto joined = [&](std::uint32_t a, std::uint32_t b) {
    return length(mesh.vertices[a] - mesh.vertices[b]) < 1.1f;
  };
  for (std::uint32_t a = 0; a < 12; ++a) {
    for (std::uint32_t b = a + 1; b < 12; ++b) {
      for (std::uint32_t c = b + 1; c < 12; ++c) {
        if (!joined(a, b) || !joined(b, c) || !joined(a, c)) continue;
        const Vec3f& p = mesh.vertices[a];
        const Vec3f n = cross(mesh.vertices[b] - p, mesh.vertices[c] - p);
        mesh.faces.push_back(dot(n, p) > 0 ? Face{a, b, c} : Face{a, c, b});
      }
    }
  }
  return mesh;
}

}  // namespace

void TestMesh::append(const TestMesh& other) {
  const auto first = static_cast<std::uint32_t>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Face& f : other.faces) faces.push_back({f[0] + first, f[1] + first, f[2] + first});
}

TestMesh single_triangle() { return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}; }

TestMesh cube(float lo, float hi) { return box({lo, lo, lo}, {hi, hi, hi}); }

TestMesh box(const Vec3f& lo, const Vec3f& hi) {
  TestMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    mesh.vertices.push_back({(corner & 1) != 0 ? hi.x : lo.x, (corner & 2) != 0 ? hi.y : lo.y,
                             (corner & 4) != 0 ? hi.z : lo.z});
  }
  mesh.faces = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

TestMesh staircase(std::uint32_t steps) {
  TestMesh mesh;
  for (std::uint32_t i = 0; i < steps; ++i) {
    const auto x = static_cast<float>(i), z = static_cast<float>(i);
    add_quad(mesh, {x, 0, z}, {x + 1, 0, z}, {x + 1, 1, z}, {x, 1, z});
    add_quad(mesh, {x + 1, 0, z}, {x + 1, 0, z + 1}, {x + 1, 1, z + 1}, {x + 1, 1, z});
  }
  return mesh;
}

TestMesh planar_sheet(std::uint32_t n) {
  TestMesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      mesh.vertices.push_back({static_cast<float>(x), static_cast<float>(y), 0});
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 2, d = a + n + 1;
      mesh.faces.push_back({a, b, c});
      mesh.faces.push_back({a, c, d});
    }
  }
  return mesh;
}

TestMesh flat_walls(std::uint32_t count) {
  TestMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto x = static_cast<float>(i);
    add_quad(mesh, {x, 0, 0}, {x, 0, 1}, {x, 1, 1}, {x, 1, 0});
  }
  return mesh;
}

TestMesh duplicates(std::uint32_t count) {
  TestMesh mesh = single_triangle();
  mesh.faces.assign(count, mesh.faces.front());
  return mesh;
}

std::vector<std::pair<double, double>> unit_circle(std::uint32_t corners) {
  // Halving a quarter turn needs only square roots, which round the same way everywhere; sines do
  // not.
  double cosine = 0, sine = 1;
  for (std::uint32_t n = 4; n < corners; n *= 2) {
    const double half = std::sqrt((1 + cosine) / 2);
    sine = sine / (2 * half);
    cosine = half;
  }
  std::vector<std::pair<double, double>> circle;
  double x = 1, y = 0;
  for (std::uint32_t i = 0; i < corners; ++i) {
    circle.emplace_back(x, y);
    std::tie(x, y) = std::pair(x * cosine - y * sine, x * sine + y * cosine);
  }
  return circle;
}

TestMesh fan(std::uint32_t blades) {
  TestMesh mesh;
  mesh.vertices.push_back({0, 0, 0});
  for (const auto& [x, y] : unit_circle(blades)) mesh.vertices.push_back(Vec3f(Vec3d{x, y, 0}));
  for (std::uint32_t i = 0; i < blades; ++i) mesh.faces.push_back({0, 1 + i, 1 + (i + 1) % blades});
  return mesh;
}

TestMesh random_soup(std::uint32_t triangles, double size, std::uint64_t seed) {
  Random random(seed);
  TestMesh mesh;
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const Vec3d center{random.uniform(), random.uniform(), random.uniform()};
    for (int k = 0; k < 3; ++k) {
      mesh.vertices.push_back(Vec3f(center + random.direction() * size));
    }
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

TestMesh icosphere(int level) {
  TestMesh mesh = icosahedron();
  for (int step = 0; step < level; ++step) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) {
        const Vec3d sum = Vec3d(mesh.vertices[a]) + Vec3d(mesh.vertices[b]);
        mesh.vertices.push_back(Vec3f(sum * (1 / length(sum))));
      }
      return entry->second;
    };
    std::vector<Face> finer;
    finer.reserve(mesh.faces.size() * 4);
    for (const Face& f : mesh.faces) {
      const std::uint32_t ab = middle(f[0], f[1]), bc = middle(f[1], f[2]), ca = middle(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], ab, ca}, {ab, f[1], bc}, {ca, bc, f[2]}, {ab, bc, ca}});
    }
    mesh.faces = std::move(finer);
  }
  return mesh;
}

std::vector<accel::geometry::Ray> rays_at(const TestMesh& mesh, std::size_t count,
                                          std::uint64_t seed) {
  accel::geometry::Aabb bounds;
  for (const Vec3f& v : mesh.vertices) bounds.grow(v);
  const Vec3d lo(bounds.lo), hi(bounds.hi);
  const Vec3d center = (lo + hi) * 0.5;
  const double radius = 1.5 * length(hi - lo);
  Random random(seed);
  std::vector<accel::geometry::Ray> rays(count);
  for (accel::geometry::Ray& ray : rays) {
    ray.origin = center + random.direction() * radius;
    const Vec3d target{random.uniform(lo.x, hi.x), random.uniform(lo.y, hi.y),
                       random.uniform(lo.z, hi.z)};
    ray.direction = target - ray.origin;
  }
  return rays;
}

}  // namespace sightline::tests
