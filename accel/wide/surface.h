// Weights and normals of the hits of a packet.
#pragma once

#include <cstdint>

#include "accel/wide/packet.h"
#include "accel/wide/transform.h"

namespace sightline::accel::wide {

struct Surfaces {
  Column<float> u, v;  ///< Weights, as in geometry::Barycentric.
  /// The normals, of length 1, in the frame that `matrix` leads from; `no_normal` has a bit where a
  /// triangle has none.
  std::array<Column<float>, 3> normal;
  std::uint32_t no_normal = 0;
};

/// Sets weights and normals for hits in `lanes`, all in one instance and with blocks. `matrix`
/// leads into the instance's frame. The numbers are those of geometry::barycentric, and of one hit
/// at a time, bit for bit.
void find_surfaces(const GivenRays& given, const BestHits& hits, const Matrix& matrix,
                   std::uint32_t lanes, Surfaces& out);

}  // namespace sightline::accel::wide
