// Hard shapes of very different sizes, and the plain shape that all are compared with.
#include <algorithm>

#include "tests/support/hard_parts.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {

using accel::geometry::Vec3d;

TestMesh hills(std::uint32_t triangles, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  const double step = 1 / std::sqrt(0.5 * triangles + 1);
  const auto height = [](double x, double z) {
    // Parabolas instead of sines: they round the same way on every machine.
    const auto wave = [](double t) {
      const double phase = t - std::floor(t) - 0.5;
      return 4 * phase * phase;
    };
    double y = 0;
    for (const double f : {2.0, 5.0, 11.0}) y += wave(f * (x + 0.3 * z)) * wave(f * (z - x)) / f;
    return y / 12;
  };
  add_lattice(mesh, triangles, {0, 0, 0}, {1, 0, 0}, {0, 0, 1},
              [&](const Vec3d& p, std::uint32_t, std::uint32_t) {
                const double x = p.x + 0.3 * step * random.uniform();
                const double z = p.z + 0.3 * step * random.uniform();
                return Vec3d{x, height(x, z), z};
              });
  return mesh;
}

TestMesh ball(std::uint32_t triangles, const Vec3d& center, double radius, double noise,
              std::uint64_t seed) {
  TestMesh mesh = tiled_cube(triangles);
  Random random(seed);
  const double width = std::min(1.0, 2 * std::sqrt(12 / (1.0 + triangles)));
  for (accel::geometry::Vec3f& vertex : mesh.vertices) {
    const Vec3d from_middle = Vec3d(vertex) - Vec3d{0.5, 0.5, 0.5};
    const double far = radius * (1 + noise * width * random.uniform(-0.5, 0.5));
    vertex = accel::geometry::Vec3f(center + from_middle * (far / length(from_middle)));
  }
  return mesh;
}

TestMesh ball_in_stadium(std::uint32_t triangles, std::uint64_t seed) {
  constexpr double kRadius = 0.004;  // In a box of 1 by 0.25 by 1: about a millionth of its volume
  const std::uint32_t seats = triangles / 10;
  TestMesh mesh;
  Random random(seed);
  // Four stands that rise away from the pitch.
  for (std::uint32_t stand = 0; stand < 4; ++stand) {
    const auto turned = [&](const Vec3d& p) {
      Vec3d q = p - Vec3d{0.5, 0, 0.5};
      for (std::uint32_t quarter = 0; quarter < stand; ++quarter) q = {-q.z, q.y, q.x};
      return q + Vec3d{0.5, 0, 0.5};
    };
    add_lattice(mesh, seats / 4, {0, 0.25, 0}, {1, 0, 0}, {0, -0.25, 0.25},
                [&](const Vec3d& p, std::uint32_t, std::uint32_t) { return turned(p); });
  }
  const auto rest = triangles - static_cast<std::uint32_t>(mesh.faces.size());
  mesh.append(ball(rest, {0.5 + 0.1 * random.uniform(), kRadius, 0.5}, kRadius, 0.3, seed));
  return mesh;
}

TestMesh nested_balls(std::uint32_t triangles, std::uint64_t seed) {
  constexpr std::uint32_t kScales = 10;
  TestMesh mesh;
  double radius = 1;
  for (std::uint32_t scale = 0; scale < kScales; ++scale, radius *= 1e-3) {
    const std::uint32_t part = triangles / kScales + (scale < triangles % kScales ? 1 : 0);
    mesh.append(ball(part, {0, 0, 0}, radius, 0.3, seed + scale));
  }
  return mesh;
}

TestMesh halving_staircase(std::uint32_t triangles, std::uint64_t seed) {
  constexpr std::uint32_t kSteps = 60;
  TestMesh mesh;
  Random random(seed);
  double width = 1;
  for (std::uint32_t step = 0; step < kSteps; ++step, width /= 2) {
    const std::uint32_t part = triangles / kSteps + (step < triangles % kSteps ? 1 : 0);
    add_scattered(mesh, part, {0, 0, 0}, width, random);
  }
  return mesh;
}

TestMesh huge_and_tiny(std::uint32_t triangles, std::uint64_t seed) {
  TestMesh mesh = tiled_cube(triangles / 3);
  for (accel::geometry::Vec3f& v : mesh.vertices) {
    const Vec3d p = Vec3d(v) - Vec3d{0.5, 0.5, 0.5};
    v = accel::geometry::Vec3f(Vec3d{p.x * 5.9e11, p.y * 1.2e5, p.z * 1.2e5});
  }
  TestMesh ground = hills(triangles / 3, seed);
  for (accel::geometry::Vec3f& v : ground.vertices) v = accel::geometry::Vec3f(Vec3d(v) * 1e3);
  mesh.append(ground);
  const auto rest = triangles - static_cast<std::uint32_t>(mesh.faces.size());
  mesh.append(ball(rest, {0, 0, 0}, 1e-3, 0.3, seed));
  return mesh;
}

}  // namespace sightline::tests
