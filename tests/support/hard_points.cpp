// Points on which searches for the closest face fail.
#include "tests/support/hard_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/support/brute_force.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;
using Corners = std::array<Vec3d, 3>;  // In the world, rounded

struct WorldBox {
  Vec3d lo{HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  void grow(const Vec3d& v) {
    lo = {std::min(lo.x, v.x), std::min(lo.y, v.y), std::min(lo.z, v.z)};
    hi = {std::max(hi.x, v.x), std::max(hi.y, v.y), std::max(hi.z, v.z)};
  }
  Vec3d middle() const { return (lo + hi) * 0.5; }
};

struct WorldFaces {
  std::vector<Corners> faces;
  WorldBox box;
};

WorldFaces faces_in_world(const PlacedMesh& placed) {
  WorldFaces world;
  for (const accel::geometry::Face& face : placed.mesh.faces) {
    Corners corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = face[k] < placed.mesh.vertices.size()
                       ? placed.world_from_local.point(Vec3d(placed.mesh.vertices[face[k]]))
                       : Vec3d{HUGE_VAL, 0, 0};
    }
    if (!is_finite(corners[0]) || !is_finite(corners[1]) || !is_finite(corners[2])) continue;
    world.faces.push_back(corners);
    for (const Vec3d& v : corners) world.box.grow(v);
  }
  return world;
}

// The sums of twelve uniform numbers: about normal, and the same on every machine.
Vec3d gaussian(Random& random) {
  Vec3d sum{-6, -6, -6};
  for (std::size_t i = 0; i < 36; ++i) sum[i % 3] += random.uniform();
  return sum;
}

Vec3d center_of(const Corners& face) { return (face[0] + face[1] + face[2]) * (1.0 / 3); }

Vec3d on_face(const Corners& face, Random& random) {
  double u = random.uniform(), v = random.uniform();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return face[0] + (face[1] - face[0]) * u + (face[2] - face[0]) * v;
}

// The center of the face, if it has hardly any area.
Vec3d circumcenter(const Corners& face) {
  const Vec3d b = face[1] - face[0], c = face[2] - face[0], n = cross(b, c);
  const Vec3d offset = cross(n, b) * dot(c, c) + cross(c, n) * dot(b, b);
  const Vec3d center = face[0] + offset * (0.5 / dot(n, n));
  return length(center - face[0]) < 0x1p+200 ? center : center_of(face);
}

Vec3d unit_normal(const Corners& face) {
  const Vec3d n = cross(face[1] - face[0], face[2] - face[0]);
  return dot(n, n) > 0 ? n * (1 / length(n)) : Vec3d{0, 0, 1};
}

// On the plane that halves the angle of two faces, if they share a corner.
Vec3d between(const Corners& face, const Corners& other, double distance) {
  Vec3d shared = (center_of(face) + center_of(other)) * 0.5;
  for (const Vec3d& v : face) {
    if (std::find(other.begin(), other.end(), v) != other.end()) shared = v;
  }
  return shared + (unit_normal(face) + unit_normal(other)) * distance;
}

Vec3d within(const WorldBox& box, Random& random) {
  Vec3d p = box.middle();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    p[axis] += 0.6 * (box.hi[axis] - box.lo[axis]) * random.uniform(-1, 1);
  }
  return p;
}

// One or two coordinates are a vertex's, or those of a side of the mesh's box: the planes of cells.
Vec3d on_planes(Vec3d p, const Vec3d& vertex, const WorldBox& box, Random& random) {
  const std::array<Vec3d, 3> planes{vertex, box.lo, box.hi};
  const std::size_t axis = random.below(3), next = (axis + random.below(2)) % 3;
  for (const std::size_t k : {axis, next}) p[k] = planes[random.below(3)][k];
  return p;
}

}  // namespace

std::vector<Vec3d> hard_points(const scenegraph::revision::Snapshot& snapshot, std::uint64_t seed,
                               std::size_t count) {
  std::vector<WorldFaces> meshes;
  WorldBox box;
  for (const PlacedMesh& placed : placed_meshes(snapshot)) {
    WorldFaces world = faces_in_world(placed);
    if (world.faces.empty()) continue;
    box.grow(world.box.lo);
    box.grow(world.box.hi);
    meshes.push_back(std::move(world));
  }
  std::vector<Vec3d> points;
  if (meshes.empty()) return points;
  const double extent = length(box.hi - box.lo), diagonal = extent > 0 ? extent : 1;

  Random random(seed);
  while (points.size() < count) {
    const WorldFaces& mesh = meshes[random.below(meshes.size())];
    const std::size_t f = random.below(mesh.faces.size());
    Corners face = mesh.faces[f];
    std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(random.below(3)),
                face.end());
    const Corners& neighbor = mesh.faces[(f + 1) % mesh.faces.size()];
    const Vec3d vertex = face[0], surface = on_face(face, random), inside = within(box, random);
    const std::array<Vec3d, kHardPointKinds> kinds{
        surface + gaussian(random) * (0.01 * diagonal),
        inside,
        box.middle() + random.direction() * (10 * diagonal),
        box.middle() + random.direction() * (1e9 * diagonal),
        vertex,
        beside<double>(vertex, random),
        beside<float>(vertex, random),
        (vertex + face[1]) * 0.5,
        center_of(face),
        beside<double>(center_of(face), random),
        beside<float>(center_of(face), random),
        between(face, neighbor, random.uniform(-0.1, 0.1) * diagonal),
        random.below(2) == 0 ? circumcenter(face) : mesh.box.middle(),
        on_planes(inside, vertex, mesh.box, random)};
    points.push_back(kinds[points.size() % kHardPointKinds]);
  }
  return points;
}

}  // namespace sightline::tests
