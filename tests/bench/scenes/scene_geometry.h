// A scene's triangles in world space, in double: their bounds, and random points on their surface.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "accel/geometry/vec3.h"
#include "tests/bench/scenes/scene_source.h"
#include "tests/support/random.h"

namespace sightline::bench {

/// Refers to the scene, which must outlive it. Triangles with a non-finite vertex are skipped.
class SceneGeometry {
 public:
  explicit SceneGeometry(const SceneSource& scene);

  const accel::geometry::Vec3d& lo() const { return lo_; }
  const accel::geometry::Vec3d& hi() const { return hi_; }
  accel::geometry::Vec3d center() const { return (lo_ + hi_) * 0.5; }
  double diagonal() const { return length(hi_ - lo_); }
  bool empty() const { return triangles_ == 0; }
  std::uint64_t triangles() const { return triangles_; }  ///< Over all instances.

  using Corners = std::array<accel::geometry::Vec3d, 3>;
  /// The n-th triangle over all instances, in world space; n < triangles().
  Corners triangle(std::uint64_t n) const;

 private:
  struct Placed {
    std::size_t mesh;
    scenegraph::model::Affine world_from_local;
    std::uint64_t first;  // Number of its first triangle in the scene
  };

  const SceneSource* scene_;
  std::vector<std::vector<std::uint32_t>> usable_;  // By mesh: its finite triangles
  std::vector<Placed> placed_;
  accel::geometry::Vec3d lo_, hi_;
  std::uint64_t triangles_ = 0;
};

/// Picks triangles with probability proportional to their area.
class AreaSampler {
 public:
  explicit AreaSampler(const SceneGeometry& geometry);
  struct Point {
    accel::geometry::Vec3d position;
    accel::geometry::Vec3d normal;  ///< Unit length.
  };
  /// Precondition: the scene has positive area.
  Point pick(tests::Random& random) const;
  bool empty() const { return cumulative_.empty() || cumulative_.back() <= 0; }

 private:
  const SceneGeometry* geometry_;
  std::vector<double> cumulative_;
};

}  // namespace sightline::bench
