// The families of points.
#include "tests/support/point_families.h"

#include <array>
#include <cmath>
#include <utility>

#include "tests/support/brute_force.h"
#include "tests/support/hard_points.h"
#include "tests/support/hard_shapes.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;
using scenegraph::revision::Snapshot;
using Points = std::vector<Vec3d>;

/// Whole numbers, so that points of quarters of its faces are exact.
constexpr Affine kExact{{0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 2, -4}};

/// Calls make(Random&) for each point. Two of three are moved: to the next doubles, and to the next
/// floats.
template <class Make>
Points points_and_beside(std::uint64_t seed, std::size_t count, const Make& make) {
  Random random(seed);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d p = make(random);
    points.push_back(i % 3 == 0   ? p
                     : i % 3 == 1 ? beside<double>(p, random)
                                  : beside<float>(p, random));
  }
  return points;
}

/// hard_points() but for those 1e9 diagonals away, which far_away() has for a small mesh: floats
/// see all faces at one distance from there, so that all are decided.
Points near_points(const Snapshot& snapshot, std::uint64_t seed, std::size_t count) {
  constexpr std::size_t kFar = 3;
  const Points all = hard_points(snapshot, seed,
                                 count / (kHardPointKinds - 1) * kHardPointKinds + kHardPointKinds);
  Points points;
  for (std::size_t i = 0; points.size() < count; ++i) {
    if (i % kHardPointKinds != kFar) points.push_back(all[i]);
  }
  return points;
}

/// The faces of a random node.
struct SomeFace {
  std::array<Vec3d, 3> corner;
  Affine frame;

  SomeFace(const std::vector<PlacedMesh>& meshes, Random& random) {
    const PlacedMesh& placed = meshes[random.below(meshes.size())];
    const auto& face = placed.mesh.faces[random.below(placed.mesh.faces.size())];
    frame = placed.world_from_local;
    for (std::size_t k = 0; k < 3; ++k) corner[k] = Vec3d(placed.mesh.vertices[face[k]]);
  }
  Vec3d at(double u, double v) const {
    return corner[0] + (corner[1] - corner[0]) * u + (corner[2] - corner[0]) * v;
  }
};

/// On a face, an edge or a corner: at quarters, which are exact on a grid.
Points on_faces(const Snapshot& snapshot, std::uint64_t seed, std::size_t count) {
  const std::vector<PlacedMesh> meshes = placed_meshes(snapshot);
  return points_and_beside(seed, count, [&](Random& random) {
    const SomeFace face(meshes, random);
    const std::uint64_t u = random.below(5), v = random.below(5 - u);
    return face.frame.point(face.at(0.25 * static_cast<double>(u), 0.25 * static_cast<double>(v)));
  });
}

/// As far from a tread as from a riser, in a corner of stairs() or outside of one; or half way
/// between two walls.
Points on_bisectors(const Snapshot&, std::uint64_t seed, std::size_t count) {
  return points_and_beside(seed, count, [](Random& random) {
    const double step = static_cast<double>(random.below(300)), y = random.uniform(-0.2, 1.2),
                 off = random.below(2) == 0 ? random.uniform(-1, 1) : 0.125;
    if (random.below(3) == 0) return Vec3d{step + 0.5, y, random.uniform(-6, -4)};
    return Vec3d{step + 1 - off, y, step + off};
  });
}
std::vector<ScenePart> stairs() {
  return {{staircase(300)}, {flat_walls(300), {placed_at({0, 0, -5})}}};
}

/// Around the middle of a ball, as near as 2^-60.
Points near_center(const Snapshot&, std::uint64_t seed, std::size_t count) {
  return points_and_beside(seed, count, [](Random& random) {
    const double off =
        random.below(4) == 0 ? 0 : std::ldexp(1.0, -static_cast<int>(random.below(60)));
    return Vec3d{1, 2, 3} + random.direction() * off;
  });
}
/// Around the axis of the tubes.
Points near_axis(const Snapshot&, std::uint64_t seed, std::size_t count) {
  return points_and_beside(seed, count, [](Random& random) {
    const double off =
        random.below(4) == 0 ? 0 : std::ldexp(1.0, -static_cast<int>(random.below(60)));
    return Vec3d{1, 2, random.uniform(-1, 5)} + random.direction() * off;
  });
}
/// Above the corner of a fan, and around it.
Points near_fan(const Snapshot& snapshot, std::uint64_t seed, std::size_t count) {
  Points points = points_and_beside(seed, count / 2, [](Random& random) {
    const auto some = [&] {
      return random.below(2) == 0 ? 0 : std::ldexp(1.0, -static_cast<int>(random.below(70)));
    };
    return Vec3d{some(), -some(), some()};
  });
  const Points hard = near_points(snapshot, seed, count - points.size());
  points.insert(points.end(), hard.begin(), hard.end());
  return points;
}

/// Whole distances along the normals of whole_planes(), up to 2^50 of them, and numbers of 53 bits
/// along the x axis, half an ulp beside another.
Points whole_distances(const Snapshot& snapshot, std::uint64_t seed, std::size_t count) {
  const std::vector<PlacedMesh> meshes = placed_meshes(snapshot);
  Random random(seed);
  Points points;
  while (points.size() < count) {
    if (random.below(3) == 0) {
      points.push_back({std::floor(random.uniform(0x1p+52, 0x1p+53)), 0, 0});
      continue;
    }
    const SomeFace face(meshes, random);
    const Vec3d normal = cross(face.corner[1] - face.corner[0], face.corner[2] - face.corner[0]);
    const bool has_area = dot(normal, normal) > 0;
    const double steps =
        std::floor(std::ldexp(1.0, static_cast<int>(random.below(44))) * random.uniform(1, 2));
    points.push_back(face.corner[random.below(3)] +
                     (has_area ? normal : Vec3d{1, 2, 2}) *
                         (random.below(2) == 0 ? steps : -steps * 0x1p-20));
  }
  return points;
}

/// 1e9 diagonals away, in any direction and along the axes; and beyond what floats see.
Points far_away(const Snapshot&, std::uint64_t seed, std::size_t count) {
  return points_and_beside(seed, count, [](Random& random) {
    const Vec3d way = random.direction();
    switch (random.below(4)) {
      case 0:
        return way * std::ldexp(1.0, 20 + static_cast<int>(random.below(105)));
      case 1:
        return Vec3d{0.5, 0.25, 4e9 * random.uniform(-1, 1)};
      default:
        return way * (3e9 * random.uniform(0.5, 2));
    }
  });
}

/// On the planes of tiny_offsets(), whose offsets are distances below 1e-300; and around the
/// origin, where coordinates below 2^-250 count as 0.
Points tiny_points(const Snapshot&, std::uint64_t seed, std::size_t count) {
  return points_and_beside(seed, count, [](Random& random) {
    if (random.below(4) == 0)
      return random.direction() * std::ldexp(1.0, -static_cast<int>(random.below(300)));
    const auto quarter = [&] { return 1 + 0.25 * static_cast<double>(random.below(33)); };
    return Vec3d{quarter(), quarter(), random.below(3) == 0 ? 0x1p-249 : 0};
  });
}
std::vector<ScenePart> tiny_offsets() {
  return {{planar_sheet(8), {placed_at({1, 1, 3e-305}), placed_at({1, 1, -1e-310})}},
          {scaled(random_soup(60, 0.2, 1), 1e-38f), {placed_at({}, 0x1p-340)}}};
}

std::vector<Affine> some_frames(std::size_t count, const Vec3d& lengths, double offset) {
  Random random(count);
  std::vector<Affine> frames;
  for (std::size_t i = 0; i < count; ++i)
    frames.push_back(turned(random, lengths,
                            {random.uniform(-offset, offset), random.uniform(-offset, offset),
                             random.uniform(-offset, offset)}));
  return frames;
}

std::vector<ScenePart> sheared() {
  std::vector<Affine> frames = some_frames(2, {1e3, 1e-3, 1}, 5);
  for (Affine& frame : frames) {
    for (std::size_t row = 0; row < 12; row += 4) frame.m[row] += 1e6 * frame.m[row + 1];
  }
  return {{icosphere(1), frames}, {random_soup(60, 0.2, 3), frames}};
}

std::vector<ScenePart> city() {
  Random random(4);
  std::vector<Affine> frames;
  for (int i = 0; i < 40; ++i) {
    const Vec3d at = random.direction() * 12.0;
    frames.push_back(turned(random, {random.uniform(0.5, 2), 1, random.uniform(-2, -0.5)}, at));
  }
  const auto some = [&](std::size_t first) {
    return std::vector<Affine>(frames.begin() + static_cast<std::ptrdiff_t>(first),
                               frames.begin() + static_cast<std::ptrdiff_t>(first + 13));
  };
  return {{icosphere(1), some(0)}, {cube(), some(13)}, {random_soup(60, 0.4, 8), some(26)}};
}

/// In floats that are a unit apart.
TestMesh far_mesh() { return on_grid(scaled(icosphere(4), 40, {1e7f, -2e7f, 3e7f}), 1); }

std::vector<PointFamily> make_table() {
  return {
      {"soup", "triangles that cross each other",
       [] { return std::vector<ScenePart>{{random_soup(3000, 0.2, 5)}}; }, near_points},
      {"hills", "a large mesh", [] { return std::vector<ScenePart>{{hills(12'000, 1)}}; },
       near_points},
      {"on-faces", "on faces, edges and corners, and beside them",
       [] {
         return std::vector<ScenePart>{{on_grid(icosphere(4), 0x1p-8f), {{}, kExact}}};
       },
       on_faces},
      {"bisectors", "as far from two faces", stairs, on_bisectors},
      {"ball-center", "in the middle of a ball",
       [] {
         return std::vector<ScenePart>{{icosphere(4), {placed_at({1, 2, 3})}}};
       },
       near_center, 0.1},
      {"tube-axis", "on the axis of a tube",
       [] {
         return std::vector<ScenePart>{{tube(256, 4), {placed_at({1, 2, 0})}}};
       },
       near_axis, 0.1},
      {"fan", "1,024 faces around one corner", [] { return std::vector<ScenePart>{{fan(1024)}}; },
       near_fan, 0.02},
      {"far-scene", "millimeters at 1e7, by the frame",
       [] {
         return std::vector<ScenePart>{
             {scaled(random_soup(2000, 0.1, 6), 1000), some_frames(2, {1e-3, 1e-3, 1e-3}, 1e7)}};
       },
       near_points},
      {"far-mesh", "vertices at 1e7", [] { return std::vector<ScenePart>{{far_mesh()}}; },
       near_points},
      {"far-points", "1e9 diagonals away, and more",
       [] { return std::vector<ScenePart>{{random_soup(64, 0.2, 7)}}; }, far_away, 0.2},
      {"sheared", "sheared 1e6 : 1", sheared, near_points},
      {"mirrored", "mirrored frames",
       [] {
         return std::vector<ScenePart>{{icosphere(4), some_frames(3, {-1, 1, 1}, 2)}};
       },
       near_points},
      {"condition", "frames with a condition of nearly 1e12",
       [] {
         return std::vector<ScenePart>{{icosphere(1), some_frames(2, {1e6, 1, 1.001e-6}, 9)}};
       },
       near_points},
      {"turned", "frames turned by irrational angles",
       [] {
         return std::vector<ScenePart>{{random_soup(2000, 0.1, 9), some_frames(3, {1, 1, 1}, 1)}};
       },
       near_points},
      {"needles", "1e8 times as long as wide",
       [] { return std::vector<ScenePart>{{long_needles(2000, 3)}}; }, near_points},
      {"zero-area", "points, segments and collinear corners",
       [] {
         return std::vector<ScenePart>{{points_and_segments(3000, 4)},
                                       {with_zero_area(2000, 5), {placed_at({0, 0, 1})}}};
       },
       near_points},
      {"duplicates", "faces again, turned around, and in two nodes",
       [] {
         return std::vector<ScenePart>{{tripled(icosphere(3)), {{}, {}}},
                                       {tripled(random_soup(300, 0.5, 2)), {kExact, kExact}}};
       },
       near_points, 0.5},
      {"whole", "whole distances, and halves of an ulp",
       [] { return std::vector<ScenePart>{{whole_planes()}}; }, whole_distances, 0.05},
      {"tiny", "distances below 1e-300", tiny_offsets, tiny_points, 0.2},
      {"denormal", "denormal vertices",
       [] {
         return std::vector<ScenePart>{{scaled(random_soup(200, 0.2, 2), 1e-40f)},
                                       {scaled(icosphere(2), 1e-38f)}};
       },
       near_points},
      {"flat", "one plane, along the axes and turned",
       [] {
         return std::vector<ScenePart>{
             {planar_sheet(32), {{}, some_frames(1, {0.5, 0.5, 0.5}, 9)[0]}}};
       },
       near_points},
      {"one-face", "a single face", [] { return std::vector<ScenePart>{{single_triangle()}}; },
       near_points},
      {"equal-faces", "100,000 equal faces",
       [] { return std::vector<ScenePart>{{duplicates(100'000)}}; }, near_points, 2e-4},
      {"city", "40 nodes, scaled unevenly", city, near_points},
  };
}

}  // namespace

const std::vector<PointFamily>& point_families() {
  static const std::vector<PointFamily> kTable = make_table();
  return kTable;
}

}  // namespace sightline::tests
