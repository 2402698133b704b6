// The distinct vertices of a few triangles.
#pragma once

#include <cstdint>

#include "accel/blocks/block.h"

namespace sightline::accel::blocks {

struct SharedVertices {
  std::uint32_t count = 0;
  /// Vertices of the mesh, in the order in which corners name them; those of one corner come
  /// before those of the next.
  std::uint32_t vertices[3 * kBlockTriangles];
  /// For every corner the index of its vertex in each triangle. Zeros behind the last triangle.
  alignas(16) std::uint8_t corners[3][kBlockTriangles] = {};
};

}  // namespace sightline::accel::blocks
