// The points of the measurements.
#include "tests/bench/scenes/point_kinds.h"

#include <algorithm>
#include <cmath>

namespace sightline::bench {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using tests::Random;

namespace {

/// The sum of twelve uniform numbers is about normal.
double gaussian(Random& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.uniform();
  return sum;
}

}  // namespace

PointKinds::PointKinds(const scenegraph::revision::Snapshot& snapshot)
    : meshes_(tests::placed_meshes(snapshot)),
      lo_{HUGE_VAL, HUGE_VAL, HUGE_VAL},
      hi_{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL} {
  for (const tests::PlacedMesh& placed : meshes_) {
    for (const Vec3f& v : placed.mesh.vertices) {
      const Vec3d p = placed.world_from_local.point(Vec3d(v));
      if (!is_finite(p)) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lo_[axis] = std::min(lo_[axis], p[axis]);
        hi_[axis] = std::max(hi_[axis], p[axis]);
      }
    }
  }
}

Vec3d PointKinds::on_surface(Random& random) const {
  for (;;) {
    const tests::PlacedMesh& placed = meshes_[random.below(meshes_.size())];
    if (placed.mesh.faces.empty()) continue;
    const accel::geometry::Face& face = placed.mesh.faces[random.below(placed.mesh.faces.size())];
    if (face[0] == accel::geometry::kNoVertex) continue;
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const auto corner = [&](std::size_t k) {
      return placed.world_from_local.point(Vec3d(placed.mesh.vertices[face[k]]));
    };
    const Vec3d p = corner(0) + (corner(1) - corner(0)) * u + (corner(2) - corner(0)) * v;
    if (is_finite(p)) return p;
  }
}

Vec3d PointKinds::near(const Vec3d& p, Random& random) const {
  const double by = 0.01 * diagonal();
  Vec3d moved = p;
  for (std::size_t axis = 0; axis < 3; ++axis) moved[axis] += by * gaussian(random);
  return moved;
}

Vec3d PointKinds::make(std::string_view kind, Random& random) const {
  const Vec3d middle = (lo_ + hi_) * 0.5;
  Vec3d p;
  if (kind == "near") {
    p = near(on_surface(random), random);
  } else if (kind == "touch") {
    p = on_surface(random);
  } else if (kind == "volume") {
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] = middle[axis] + 1.2 * (hi_[axis] - lo_[axis]) * (random.uniform() - 0.5);
  } else {
    p = middle + random.direction() * (10 * diagonal());
  }
  return Vec3d(Vec3f(p));
}

}  // namespace sightline::bench
