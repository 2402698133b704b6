// What has to be known of a mesh's arrays before any ray comes: are the indices good, what can be
// hit, and where does it lie.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/geometry/aabb.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/mesh/face_boxes.h"

namespace sightline::accel::mesh {

struct MeshStats {
  std::uint64_t triangles = 0;         ///< Faces that hold one.
  std::uint64_t finite_triangles = 0;  ///< With finite vertices: what can be hit.
  /// The first face with an index out of range; it and its like count as triangles, never as
  /// finite.
  std::size_t first_bad_face = FaceSum::kNone;
  /// Holds the finite triangles; vertices that none of them has may make it larger, but not by
  /// much. Of positive extent; empty if there is none.
  geometry::Aabb bounds;
};

/// Streams through the arrays once, and looks at single faces only where something is odd: an index
/// out of range, a vertex that is not finite, vertices far from the faces. Parallel in the caller's
/// arena; the result does not depend on it.
MeshStats compute_mesh_stats(const geometry::MeshView& mesh);

}  // namespace sightline::accel::mesh
