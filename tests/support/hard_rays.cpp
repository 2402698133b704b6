// Rays on which walks and tests fail.
#include "tests/support/hard_rays.h"

#include <algorithm>

#include "accel/geometry/aabb.h"
#include "accel/geometry/local_ray.h"
#include "tests/support/random.h"

namespace sightline::tests {
namespace {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

// One of the 26 directions to the neighbors in a lattice; zeros have either sign.
Vec3d lattice_direction(Random& random) {
  for (;;) {
    Vec3d d;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      constexpr double kParts[] = {-1, -0.0, 0.0, 1};
      d[axis] = kParts[random.below(4)];
    }
    if (d.x != 0 || d.y != 0 || d.z != 0) return d;
  }
}

class HardRays {
 public:
  explicit HardRays(const TestMesh& mesh) : mesh_(mesh) {
    for (const accel::geometry::Face& face : mesh.faces) {
      bool finite = true;
      for (const std::uint32_t v : face) finite = finite && is_finite(Vec3d(mesh.vertices[v]));
      if (!finite) continue;
      finite_.push_back(face);
      for (const std::uint32_t v : face) bounds_.grow(mesh.vertices[v]);
    }
    lo_ = Vec3d(bounds_.lo);
    hi_ = Vec3d(bounds_.hi);
    diagonal_ = finite_.empty() ? 0 : std::max(length(hi_ - lo_), 1e-300);
  }

  bool empty() const { return finite_.empty(); }

  Ray make(std::size_t kind, Random& random) const {
    const accel::geometry::Face& face = finite_[random.below(finite_.size())];
    const std::size_t corner = random.below(3);
    const Vec3d vertex(mesh_.vertices[face[corner]]);
    const Vec3d next(mesh_.vertices[face[(corner + 1) % 3]]);
    const Vec3d afar = (lo_ + hi_) * 0.5 + random.direction() * (1.5 * diagonal_);
    const Vec3d within = point(random);
    const Vec3d step = lattice_direction(random);
    switch (kind) {
      case 0:
        return {afar, within - afar};
      case 1:
        return {within, random.direction()};
      case 2:
        return {afar, vertex - afar};
      case 3:
        return {afar, vertex + (next - vertex) * random.uniform() - afar};
      case 4:
        return {vertex - step * (2 * diagonal_), step};
      case 5:
        return {vertex, step};
      case 6:
        return in_plane(vertex, within, random);
      default:
        return {afar, vertex - afar, random.uniform() < 0.5 ? 0.0 : 1.0, 1};
    }
  }

 private:
  Vec3d point(Random& random) const {
    const double x = random.uniform(lo_.x, hi_.x), y = random.uniform(lo_.y, hi_.y);
    return {x, y, random.uniform(lo_.z, hi_.z)};
  }

  // Begins in the plane across an axis through the vertex; every other time it stays in that plane.
  Ray in_plane(const Vec3d& vertex, const Vec3d& within, Random& random) const {
    const std::size_t axis = random.below(3);
    Ray ray{within, random.direction()};
    ray.origin[axis] = vertex[axis];
    if (random.below(2) == 0) {
      ray.direction[axis] = random.below(2) == 0 ? 0.0 : -0.0;
      ray.origin = ray.origin - ray.direction * (2 * diagonal_);
    }
    return ray;
  }

  const TestMesh& mesh_;
  std::vector<accel::geometry::Face> finite_;
  accel::geometry::Aabb bounds_;
  Vec3d lo_, hi_;
  double diagonal_;
};

}  // namespace

std::vector<Ray> make_hard_rays(const TestMesh& mesh, std::size_t count, std::uint64_t seed) {
  const HardRays maker(mesh);
  std::vector<Ray> rays;
  if (maker.empty()) return rays;
  rays.reserve(count);
  Random random(seed);
  for (std::size_t turn = 0; rays.size() < count; ++turn) {
    const Ray ray = maker.make(turn % kHardRayKinds, random);
    if (accel::geometry::make_local_ray(ray.origin, ray.direction)) rays.push_back(ray);
  }
  return rays;
}

}  // namespace sightline::tests
