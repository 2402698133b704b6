// The answers to the rays of a packet in columns.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/geometry/hit_columns.h"
#include "accel/wide/packet.h"

namespace sightline::accel::wide {

/// What is known of a packet's rays when they have been cast; sets have a bit for each ray.
struct Outcome {
  const BestHits& best;
  const Column<std::uint32_t>& work;
  std::uint32_t answered = 0;      ///< The rays to write: the first ones, perhaps with gaps.
  std::uint32_t valid = 0;         ///< The rays that are not invalid.
  std::uint32_t saw_deferred = 0;  ///< The rays that met a cell which is not built (Hit::work).
  bool any = false;                ///< Whether only the existence of hits is known.
};

/// Writes all asked fields of answered rays to the rows `first` and following; `first` is a
/// multiple of kLanes. Weights and normals are zero, for others to replace. Bits of rays that are
/// not answered stay.
void write(const Outcome& outcome, const geometry::HitColumns& hits, std::size_t first);

}  // namespace sightline::accel::wide
