// Facts about a mesh's arrays that are needed before the first ray: whether indices are in range,
// how many triangles can be hit, and their bounds.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/geometry/aabb.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::accel::mesh {

struct MeshStats {
  std::uint64_t triangles = 0;         ///< Faces with a triangle.
  std::uint64_t finite_triangles = 0;  ///< Triangles with finite vertices: those that can be hit.
  /// The first face with an index out of range; beyond all faces if there is none. Such faces count
  /// as triangles, but not as finite.
  std::size_t first_bad_face = ~std::size_t{0};
  /// The box of all finite triangles; vertices that no triangle uses may make it a little larger.
  /// It has a positive extent on each axis, and is empty if there are no finite triangles.
  geometry::Aabb bounds;
};

/// Reads the arrays once. Reads single faces only if the mesh is irregular: an index out of range,
/// a vertex that is not finite, vertices far from the faces. Parallel in the caller's arena; the
/// result does not depend on the number of threads.
MeshStats compute_mesh_stats(const geometry::MeshView& mesh);

}  // namespace sightline::accel::mesh
