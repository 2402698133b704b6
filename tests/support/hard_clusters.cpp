// Flat, coincident and clustered triangles.
#include "tests/support/hard_clusters.h"

#include <array>
#include <cmath>

#include "tests/support/find_named.h"
#include "tests/support/hard_parts.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;
using Count = std::uint32_t;

/// One random triangle after the other: `corner(random, center)` for each of three corners.
template <class Center, class Corner>
TestMesh random_triangles(Count triangles, std::uint64_t seed, const Center& center,
                          const Corner& corner) {
  TestMesh mesh;
  Random random(seed);
  for (Count i = 0; i < triangles; ++i) {
    const Vec3d at = center(random);
    const Vec3d a = corner(random, at), b = corner(random, at);
    add_triangle(mesh, a, b, corner(random, at));
  }
  return mesh;
}

Vec3d in_square(Random& random) {
  const double x = random.uniform();
  return {x, random.uniform(), 0};
}

Vec3d in_cube(Random& random, double width) {
  const double x = random.uniform(0, width), y = random.uniform(0, width);
  return {x, y, random.uniform(0, width)};
}

Vec3d nowhere(Random&) { return {}; }

/// Corners anywhere in the unit square, at the height that `height(random, x, y)` gives.
template <class Height>
TestMesh sheets(Count triangles, std::uint64_t seed, const Height& height) {
  return random_triangles(triangles, seed, nowhere, [&](Random& random, const Vec3d&) {
    Vec3d p = in_square(random);
    p.z = height(random, p);
    return p;
  });
}

TestMesh flat(Count n, std::uint64_t seed) {
  return sheets(n, seed, [](Random&, const Vec3d&) { return 0.0; });
}

TestMesh flat_small(Count n, std::uint64_t seed) {
  return random_triangles(n, seed, in_square, [](Random& random, const Vec3d& at) {
    constexpr double kWidth = 0.1;
    return at + in_square(random) * kWidth;
  });
}

TestMesh tilted(Count n, std::uint64_t seed) {
  return sheets(n, seed, [](Random&, const Vec3d& p) { return 0.3 * p.x + 0.2 * p.y; });
}

TestMesh jittered(Count n, std::uint64_t seed) {
  return sheets(n, seed, [](Random& random, const Vec3d&) { return 1e-3 * random.uniform(); });
}

TestMesh layers(Count n, std::uint64_t seed) {
  const auto layer = [](Random& random) {
    return Vec3d{0, 0, 0.1 * static_cast<double>(random.below(8))};
  };
  return random_triangles(n, seed, layer,
                          [](Random& random, const Vec3d& at) { return at + in_square(random); });
}

TestMesh star(Count n, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  for (Count i = 0; i < n; ++i) {
    const Vec3d a = random.direction(), b = random.direction();
    add_triangle(mesh, {0, 0, 0}, a, a + b * 0.02);
  }
  return mesh;
}

TestMesh needles_in_line(Count n, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  for (Count i = 0; i < n; ++i) {
    const double from = random.uniform(), to = random.uniform();
    add_triangle(mesh, {from, 0, 0}, {to, 0, 0}, Vec3d{(from + to) / 2, 1e-4, 1e-4});
  }
  return mesh;
}

TestMesh concentric(Count n, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  for (Count i = 0; i < n; ++i) {
    const double size = 1 + random.uniform();
    const Vec3d u = random.direction() * size, v = random.direction() * size;
    add_triangle(mesh, u, v, (u + v) * -1.0);
  }
  return mesh;
}

TestMesh crossing_planes(Count n, std::uint64_t seed) {
  const auto normal = [](Random& random) {
    Vec3d axis{};
    axis[random.below(3)] = 1;
    return axis;
  };
  return random_triangles(n, seed, normal, [](Random& random, const Vec3d& across) {
    Vec3d p = in_cube(random, 1) - Vec3d{0.5, 0.5, 0.5};
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] *= 1 - across[axis];
    return p;
  });
}

/// Eight clusters of eight clusters of eight, each a thousandth as wide as the next larger one.
TestMesh clusters_of_clusters(Count n, std::uint64_t seed) {
  std::array<std::array<Vec3d, 8>, 3> positions;
  Random where(seed + 1);
  double width = 1;
  for (auto& level : positions) {
    for (Vec3d& position : level) position = in_cube(where, width);
    width *= 1e-3;
  }
  const auto center = [&](Random& random) {
    Vec3d at{};
    for (const auto& level : positions) at = at + level[random.below(8)];
    return at;
  };
  return random_triangles(n, seed, center, [](Random& random, const Vec3d& at) {
    constexpr double kWidth = 1e-6;
    return at + in_cube(random, kWidth);
  });
}

/// Floats near 1 are about 1e-7 apart, so corners have few positions.
TestMesh one_point(Count n, std::uint64_t seed) {
  return random_triangles(n, seed, nowhere, [](Random& random, const Vec3d&) {
    return Vec3d{1, 1, 1} + in_cube(random, 1e-6);
  });
}

TestMesh bundle(Count n, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  for (Count i = 0; i < n; ++i) {
    const Vec3d from = in_cube(random, 0.01), to = in_cube(random, 0.01) + Vec3d{1, 1, 1};
    add_triangle(mesh, from, to, from + in_cube(random, 0.001));
  }
  return mesh;
}

TestMesh far_clusters(Count n, std::uint64_t seed) {
  const auto center = [](Random& random) { return Vec3d{random.below(2) == 0 ? 0.0 : 1e4, 0, 0}; };
  return random_triangles(n, seed, center,
                          [](Random& random, const Vec3d& at) { return at + in_cube(random, 1); });
}

TestMesh overlapping_quads(Count n, std::uint64_t seed) {
  TestMesh mesh;
  Random random(seed);
  for (Count i = 0; mesh.faces.size() < n; ++i) {
    const Vec3d at = in_cube(random, 1);
    const std::size_t axis = random.below(3);
    Vec3d u{}, v{};
    u[(axis + 1) % 3] = v[(axis + 2) % 3] = 0.3;
    add_triangle(mesh, at, at + u, at + u + v);
    if (mesh.faces.size() < n) add_triangle(mesh, at, at + u + v, at + v);
  }
  return mesh;
}

}  // namespace

const std::vector<ClusteredMesh>& clustered_meshes() {
  static const std::vector<ClusteredMesh> kTable{
      {"flat", "one plane across an axis, corners anywhere in a square", flat},
      {"flat-small", "the same, triangles a tenth as wide", flat_small},
      {"tilted", "one tilted plane", tilted},
      {"jittered", "one plane, a thousandth thick", jittered},
      {"layers", "eight planes", layers},
      {"copies", "one triangle, again and again",
       [](Count n, std::uint64_t) { return duplicates(n); }},
      {"star", "all share a vertex, in all directions", star},
      {"needles-in-line", "needles on one line, each with its own ends", needles_in_line},
      {"concentric", "all around one centre, in all directions", concentric},
      {"crossing-planes", "three planes through one point", crossing_planes},
      {"clusters", "clusters of clusters of clusters", clusters_of_clusters},
      {"one-point", "all within a few units of the last position", one_point},
      {"bundle", "long needles along one diagonal", bundle},
      {"far-clusters", "two clusters without order, far from each other", far_clusters},
      {"quads", "overlapping squares across the axes", overlapping_quads},
  };
  return kTable;
}

const ClusteredMesh* find_clustered_mesh(std::string_view name) {
  return find_named(clustered_meshes(), name);
}

}  // namespace sightline::tests
