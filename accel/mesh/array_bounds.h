// A mesh's arrays streamed through once: the greatest index, the bounds of the vertices, and of
// some faces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::accel {

/// Zero if there are no faces.
std::uint32_t greatest_index(std::span<const Face> faces);

/// Nothing if a vertex is not finite, or there is none.
std::optional<Aabb> bounds_of_vertices(std::span<const Vec3f> vertices);

/// Of the vertices of every stride-th face. Indices are good, vertices finite.
Aabb bounds_of_faces(const MeshView& mesh, std::size_t stride);

}  // namespace sightline::accel
