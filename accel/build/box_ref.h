// A reference as the builder sees it: a weighted box. Lists of them are what is scanned and sifted.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/geometry/aabb.h"

namespace sightline::accel {

/// 32 bytes, read in order by every pass. `bounds` went through widen_flat.
struct BoxRef {
  Vec3f lo;
  std::uint32_t id = 0;  ///< What the leaf will hold: a face or an instance.
  Vec3f hi;
  std::uint32_t weight = 1;  ///< Cost of testing it, in triangle tests. A list's weights sum below 2^32.

  Aabb bounds() const { return {lo, hi}; }
};
static_assert(sizeof(BoxRef) == 32);

/// Work done by build passes, in the units of docs/benchmarks.md.
struct BuildCounters {
  std::uint64_t touches = 0;          ///< One reference's bounds read by one pass.
  std::uint64_t touches_prepare = 0;  ///< One box made from vertices.
  std::uint64_t cells_expanded = 0;   ///< Deferred cells that became inner nodes or leaves.
  double seconds = 0;                 ///< Spent expanding, summed over threads. For reports, never for decisions.

  BuildCounters& operator+=(const BuildCounters& o) {
    touches += o.touches;
    touches_prepare += o.touches_prepare;
    cells_expanded += o.cells_expanded;
    seconds += o.seconds;
    return *this;
  }
};

/// A place to cut a cell: x[axis] = position.
struct Plane {
  int axis = 0;
  float position = 0;
  bool operator==(const Plane&) const = default;
};

}  // namespace sightline::accel
