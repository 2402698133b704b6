// The points of the measurements: seed, scene and kind determine them on every machine.
#pragma once

#include <string_view>
#include <vector>

#include "accel/geometry/ray.h"
#include "scenegraph/revision/snapshot.h"
#include "tests/support/brute_force.h"
#include "tests/support/random.h"

namespace sightline::bench {

/// Makes points around the faces of a scene that has some.
class PointKinds {
 public:
  explicit PointKinds(const scenegraph::revision::Snapshot& snapshot);

  const std::vector<tests::PlacedMesh>& meshes() const { return meshes_; }
  double diagonal() const { return length(hi_ - lo_); }

  /// A point of a random face, of equal weight whatever its size.
  accel::geometry::Vec3d on_surface(tests::Random& random) const;
  /// Moved by a hundredth of the diagonal, times a normal variate on each axis.
  accel::geometry::Vec3d near(const accel::geometry::Vec3d& p, tests::Random& random) const;
  /// All are floats. near: near a point on the surface; touch: on it; volume: in 1.2 times the box;
  /// far: ten diagonals away.
  accel::geometry::Vec3d make(std::string_view kind, tests::Random& random) const;

 private:
  std::vector<tests::PlacedMesh> meshes_;
  accel::geometry::Vec3d lo_, hi_;
};

inline constexpr std::string_view kPointKinds = "near|volume|far|touch";

/// The question for the face nearest to a point.
inline accel::geometry::Ray question_at(const accel::geometry::Vec3d& p) {
  return {.origin = p, .direction = {1, 0, 0}};
}

}  // namespace sightline::bench
