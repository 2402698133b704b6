// Bounds over a mesh's arrays: the greatest index, the box of all vertices, the box of some faces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::accel::mesh {

/// The greatest vertex index; 0 if there are no faces.
std::uint32_t greatest_index(std::span<const geometry::Face> faces);

/// The box of all vertices; nothing if a vertex is not finite or there are none.
std::optional<geometry::Aabb> bounds_of_vertices(std::span<const geometry::Vec3f> vertices);

/// The box of every stride-th face. Indices must be in range, vertices finite.
geometry::Aabb bounds_of_faces(const geometry::MeshView& mesh, std::size_t stride);

}  // namespace sightline::accel::mesh
