// The faces of one node: where they are nearest to a point, and on which side of them it is.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "accel/geometry/pseudonormal.h"
#include "accel/geometry/ray.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::query {

class NodeFaces {
 public:
  /// No node's. The snapshot must outlive this.
  explicit NodeFaces(const revision::Snapshot& snapshot) : snapshot_(snapshot) {}

  /// Makes this the faces of a node that rays have met, unless it is that already.
  void enter(model::NodeId node);

  /// The point of a face of the node that is nearest to p; `hit` is its hit by p, at a distance
  /// above 0.
  accel::geometry::NearestPoint nearest_point(const accel::geometry::Vec3d& p,
                                              const accel::geometry::Hit& hit) const;

  /// Whether p is behind the node's faces at its nearest point x, the nearest_point() of `nearest`:
  /// whether the sum of the normals of all faces that contain x, weighted by their angles, points
  /// away from p. `others` has these faces, and any others; none is needed if x is inside the face.
  /// A sum that is less than 2^-88 of its terms counts as 0, which is not behind.
  bool is_behind(const accel::geometry::Vec3d& p, const accel::geometry::Hit& nearest,
                 std::span<const accel::geometry::Hit> others) const;

 private:
  struct Sum;
  struct Faces;

  std::array<accel::geometry::Vec3f, 3> corners(std::uint32_t face) const;
  Sum computed_sum(const Faces& faces) const;
  Sum exact_sum(const Faces& faces) const;

  const revision::Snapshot& snapshot_;
  model::NodeId node_ = 0;  // 0: none
  const model::Mesh* mesh_ = nullptr;
  model::Affine world_from_local_;
  bool is_mirrored_ = false;  // Normals by the winding in the scene point inward
};

}  // namespace sightline::scenegraph::query
