// A scene's triangles in world space, in double.
#include "tests/bench/scenes/scene_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::bench {

using accel::geometry::Vec3d;

SceneGeometry::SceneGeometry(const SceneSource& scene) : scene_(&scene) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  lo_ = {kInf, kInf, kInf};
  hi_ = {-kInf, -kInf, -kInf};
  usable_.resize(scene.meshes.size());
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const SourceMesh& mesh = scene.meshes[m];
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
      const bool finite =
          std::all_of(mesh.faces[f].begin(), mesh.faces[f].end(), [&](std::uint32_t index) {
            return index < mesh.vertices.size() && is_finite(mesh.vertices[index]);
          });
      if (finite) usable_[m].push_back(f);
    }
  }
  std::vector<scenegraph::model::Affine> world_from_local;
  for (const SourceNode& node : scene.nodes) {
    world_from_local.push_back(node.parent
                                   ? compose(world_from_local[*node.parent], node.parent_from_local)
                                   : node.parent_from_local);
    if (!node.mesh) continue;
    placed_.push_back({*node.mesh, world_from_local.back(), triangles_});
    triangles_ += usable_[*node.mesh].size();
    const SourceMesh& mesh = scene.meshes[*node.mesh];
    for (const std::uint32_t f : usable_[*node.mesh]) {
      for (const std::uint32_t index : mesh.faces[f]) {
        const Vec3d p = world_from_local.back().point(Vec3d(mesh.vertices[index]));
        lo_ = {std::min(lo_.x, p.x), std::min(lo_.y, p.y), std::min(lo_.z, p.z)};
        hi_ = {std::max(hi_.x, p.x), std::max(hi_.y, p.y), std::max(hi_.z, p.z)};
      }
    }
  }
  if (triangles_ == 0) lo_ = hi_ = {};
}

SceneGeometry::Corners SceneGeometry::triangle(std::uint64_t n) const {
  const auto after = std::upper_bound(placed_.begin(), placed_.end(), n,
                                      [](std::uint64_t k, const Placed& p) { return k < p.first; });
  // Several instances may begin at n; only the last of them has triangles.
  const Placed& placed = *std::prev(after);
  const SourceMesh& mesh = scene_->meshes[placed.mesh];
  const accel::geometry::Face& face = mesh.faces[usable_[placed.mesh][n - placed.first]];
  Corners corners;
  for (std::size_t i = 0; i < 3; ++i) {
    corners[i] = placed.world_from_local.point(Vec3d(mesh.vertices[face[i]]));
  }
  return corners;
}

AreaSampler::AreaSampler(const SceneGeometry& geometry) : geometry_(&geometry) {
  double sum = 0;
  cumulative_.reserve(geometry.triangles());
  for (std::uint64_t n = 0; n < geometry.triangles(); ++n) {
    const auto [a, b, c] = geometry.triangle(n);
    sum += length(cross(b - a, c - a));
    cumulative_.push_back(sum);
  }
}

AreaSampler::Point AreaSampler::pick(tests::Random& random) const {
  // Below the sum, so that the first entry above it is a triangle with area.
  const double mark =
      std::min(random.uniform() * cumulative_.back(), std::nextafter(cumulative_.back(), 0.0));
  const auto n = static_cast<std::uint64_t>(
      std::upper_bound(cumulative_.begin(), cumulative_.end(), mark) - cumulative_.begin());
  const auto [a, b, c] = geometry_->triangle(n);
  double u = random.uniform(), v = random.uniform();
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  const Vec3d normal = cross(b - a, c - a);
  return {a + (b - a) * u + (c - a) * v, normal * (1 / length(normal))};
}

}  // namespace sightline::bench
