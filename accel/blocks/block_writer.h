// Writes leaf blocks.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/blocks/hierarchy.h"
#include "accel/blocks/shared_vertices.h"
#include "accel/geometry/triangle_mesh.h"

namespace sightline::accel::blocks {

/// Makes the block of the triangles `ids`, 1 to kBlockTriangles, over at most kBlockVertices
/// vertices of the mesh, relative to the center. Throws std::bad_alloc.
const std::uint32_t* write_block(const geometry::MeshView& mesh, const geometry::Vec3f& center,
                                 const std::uint32_t* ids, std::size_t count,
                                 const SharedVertices& shared, Arena& arena);

}  // namespace sightline::accel::blocks
