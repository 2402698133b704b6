// Which vertices lie on one side of a ray, as seen along it, or outside of a part of space: a
// triangle whose corners all do is missed. This serves searches of whole meshes, as a vertex is
// read once for all its triangles.
#pragma once

#include <cstdint>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/geometry/triangle_prefilter.h"

namespace sightline::accel::geometry {

/// Four lines through the point to which the ray projects, in steps of 45 degrees, have eight
/// sides. Sets a bit of sides[i] for each side on which vertices[i] certainly lies. If the corners
/// of a triangle have a bit in common, `intersect` returns no hit.
void vertex_sides(const ShearedRay& ray, std::span<const Vec3f> vertices, std::uint8_t* sides);

/// A box without what lies beyond a plane: v with normal . v > most.
struct CutBox {
  Aabb box;
  Vec3f normal;
  float most = 0;
};

/// Sets a bit of sides[i] for each side of the box, and of the plane, on which vertices[i]
/// certainly lies outside. If the corners of a triangle have a bit in common, it is all outside.
void vertex_sides(const CutBox& part, std::span<const Vec3f> vertices, std::uint8_t* sides);

/// Writes the faces from `begin` to `end` - 1 whose corners have no bit in common, and returns
/// their number. `out` has capacity for all faces. Indices must be in range.
std::size_t faces_on_no_side(std::span<const Face> faces, std::uint32_t begin, std::uint32_t end,
                             const std::uint8_t* sides, std::uint32_t* out);

}  // namespace sightline::accel::geometry
