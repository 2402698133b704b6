// A mesh's arrays streamed through once: the greatest index, the bounds of the vertices, and of
// some faces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::accel::mesh {

/// Zero if there are no faces.
std::uint32_t greatest_index(std::span<const geometry::Face> faces);

/// Nothing if a vertex is not finite, or there is none.
std::optional<geometry::Aabb> bounds_of_vertices(std::span<const geometry::Vec3f> vertices);

/// Of the vertices of every stride-th face. Indices are good, vertices finite.
geometry::Aabb bounds_of_faces(const geometry::MeshView& mesh, std::size_t stride);

}  // namespace sightline::accel::mesh
