// Terrain, grid, icosphere, slivers, wall: single meshes made by rule.
#include <algorithm>
#include <cmath>

#include "tests/bench/scenes/generators.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::bench {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using tests::Random;

namespace {

SceneSource single(std::string name, SourceMesh mesh,
                   const scenegraph::model::Affine& transform = {}) {
  SceneSource scene;
  const std::size_t index = scene.add_mesh(std::move(mesh));
  scene.add_node(std::nullopt, std::move(name), transform, index);
  return scene;
}

// A height in [0, 1] at a lattice point.
double lattice_value(std::int64_t x, std::int64_t z) {
  return Random(static_cast<std::uint64_t>(x) * 0x9e3779b1u, static_cast<std::uint64_t>(z))
      .uniform();
}

double smooth(double t) { return t * t * (3 - 2 * t); }

double value_noise(double x, double z) {
  const double fx = std::floor(x), fz = std::floor(z);
  const auto ix = static_cast<std::int64_t>(fx), iz = static_cast<std::int64_t>(fz);
  const double u = smooth(x - fx), v = smooth(z - fz);
  const double low = lattice_value(ix, iz) * (1 - u) + lattice_value(ix + 1, iz) * u;
  const double high = lattice_value(ix, iz + 1) * (1 - u) + lattice_value(ix + 1, iz + 1) * u;
  return low * (1 - v) + high * v;
}

// Hills four to the terrain's width and five octaves of detail on them, each half as high.
double terrain_height(double x, double z, double width) {
  double height = 0, share = 0.08 * width, frequency = 4 / width;
  for (int octave = 0; octave < 6; ++octave) {
    height += share * value_noise(x * frequency, z * frequency);
    share *= 0.5;
    frequency *= 2;
  }
  return height;
}

template <class Height>
SourceMesh make_lattice(std::uint64_t triangles, const Height& height) {
  const std::uint64_t quads = (triangles + 1) / 2;
  // An odd number: with 2^k columns, cuts at simple fractions would run between triangles. Measured
  // terrain never has this, and it makes some methods appear a quarter cheaper than they are.
  const std::uint64_t columns =
      static_cast<std::uint64_t>(std::sqrt(static_cast<double>(quads))) | 1u;
  const std::uint64_t rows = (quads + columns - 1) / columns;
  const auto width = static_cast<double>(columns);
  SourceMesh mesh;
  mesh.vertices.reserve((columns + 1) * (rows + 1));
  for (std::uint64_t z = 0; z <= rows; ++z) {
    for (std::uint64_t x = 0; x <= columns; ++x) {
      const Vec3d p{static_cast<double>(x) - width / 2, 0, static_cast<double>(z) - width / 2};
      mesh.vertices.push_back(Vec3f(Vec3d{p.x, height(p.x, p.z, width), p.z}));
    }
  }
  mesh.faces.reserve(triangles);
  for (std::uint64_t quad = 0; quad < quads; ++quad) {
    const auto a = static_cast<std::uint32_t>(quad / columns * (columns + 1) + quad % columns);
    const auto below = static_cast<std::uint32_t>(a + columns + 1);
    mesh.faces.push_back({a, below, a + 1});
    if (mesh.faces.size() < triangles) mesh.faces.push_back({a + 1, below, below + 1});
  }
  return mesh;
}

}  // namespace

SceneSource make_terrain(std::uint64_t triangles) {
  return single("terrain", make_lattice(triangles, terrain_height));
}

SceneSource make_grid(std::uint64_t triangles) {
  return single("grid", make_lattice(triangles, [](double, double, double) { return 0.0; }));
}

SceneSource make_slivers(std::uint64_t triangles, std::uint64_t seed) {
  Random random(seed);
  SourceMesh mesh;
  mesh.vertices.reserve(3 * triangles);
  mesh.faces.reserve(triangles);
  for (std::uint64_t i = 0; i < triangles; ++i) {
    const Vec3d center{random.uniform(), random.uniform(), random.uniform()};
    const Vec3d along = random.direction() * 0.5;
    const Vec3d across = random.direction() * 1e-4;
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(Vec3f(center - along));
    mesh.vertices.push_back(Vec3f(center + along));
    mesh.vertices.push_back(Vec3f(center + across));
    mesh.faces.push_back({first, first + 1, first + 2});
  }
  return single("slivers", std::move(mesh));
}

SceneSource make_icosphere(int level, double offset) {
  tests::TestMesh sphere = tests::icosphere(level);
  return single("icosphere", {std::move(sphere.vertices), std::move(sphere.faces)},
                translation(offset, offset, offset));
}

SceneSource make_wall(std::uint64_t triangles, double share, double at, std::uint64_t seed) {
  const auto in_wall = static_cast<std::uint64_t>(share * static_cast<double>(triangles));
  SourceMesh mesh;
  if (in_wall > 0) mesh = make_lattice(in_wall, [](double, double, double) { return 0.0; });
  float extent = 0;
  for (const Vec3f& v : mesh.vertices) extent = std::max({extent, std::abs(v.x), std::abs(v.z)});
  // From around the origin at y = 0 to the unit square at x = at.
  for (Vec3f& v : mesh.vertices) {
    v = {static_cast<float>(at), v.x / (2 * extent) + 0.5f, v.z / (2 * extent) + 0.5f};
  }
  constexpr double kSize = 0.02;
  Random random(seed);
  while (mesh.faces.size() < triangles) {
    // Denser toward the middle of x.
    const Vec3d corner{(random.uniform() + random.uniform()) / 2 * (1 - kSize),
                       random.uniform() * (1 - kSize), random.uniform() * (1 - kSize)};
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t i = 0; i < 3; ++i) {
      const Vec3d edge{random.uniform(), random.uniform(), random.uniform()};
      mesh.vertices.push_back(Vec3f(corner + edge * kSize));
    }
    mesh.faces.push_back({first, first + 1, first + 2});
  }
  return single("wall", std::move(mesh));
}

}  // namespace sightline::bench
