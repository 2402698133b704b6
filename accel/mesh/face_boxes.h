// Boxes of a mesh's faces: of one face, of several together, and as a list of references.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::mesh {

/// The bounds of a face, widened by widen_flat; nothing if it has no triangle or a vertex is not
/// finite. Its indices must be in range.
std::optional<geometry::Aabb> face_bounds(const geometry::MeshView& mesh, std::size_t face);

/// Counts and bounds of several faces.
struct FaceSum {
  static constexpr std::size_t kNone = ~std::size_t{0};

  std::uint64_t triangles = 0;    ///< Faces with a triangle.
  std::uint64_t finite = 0;       ///< Triangles with indices in range and finite vertices.
  std::size_t first_bad = kNone;  ///< The first face with an index out of range.
  geometry::Aabb box;             ///< Union of the face_bounds of finite triangles.

  void add(const FaceSum& o);
};

/// The sum over faces `begin` to `end` - 1. Indices may be out of range.
FaceSum sum_faces(const geometry::MeshView& mesh, std::size_t begin, std::size_t end);

/// Writes a reference of weight 1 for every face from `begin` to `end` - 1 that has bounds, and
/// returns their number. `out` has capacity for all faces. Indices must be in range.
std::size_t face_references(const geometry::MeshView& mesh, std::size_t begin, std::size_t end,
                            kdtree::Reference* out);

}  // namespace sightline::accel::mesh
