// Boxes of a mesh's faces: one, a few with their sum, or a list of references.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::mesh {

/// The bounds of a face as the builder sees them (widen_flat), or nothing if it has no triangle or
/// a vertex is not finite. Its indices are good.
std::optional<geometry::Aabb> face_bounds(const geometry::MeshView& mesh, std::size_t face);

/// What a few faces add up to.
struct FaceSum {
  static constexpr std::size_t kNone = ~std::size_t{0};

  std::uint64_t triangles = 0;    ///< Faces that hold one.
  std::uint64_t finite = 0;       ///< With good indices and finite vertices.
  std::size_t first_bad = kNone;  ///< The first face with an index out of range.
  geometry::Aabb box;             ///< Of the finite ones' face_bounds.

  void add(const FaceSum& o);
};

/// Of the faces from `begin` to `end`; looks at their indices before it uses them.
FaceSum sum_faces(const geometry::MeshView& mesh, std::size_t begin, std::size_t end);

/// Writes a reference of weight one for every face from `begin` to `end` that has bounds; there is
/// room for all. Returns how many. Their indices are good.
std::size_t face_references(const geometry::MeshView& mesh, std::size_t begin, std::size_t end,
                            kdtree::Reference* out);

}  // namespace sightline::accel::mesh
