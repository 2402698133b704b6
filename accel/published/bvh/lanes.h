// Boxes in vector registers: x, y, z, and an unused fourth lane.
#pragma once

#include <limits>

#include "accel/geometry/aabb.h"

namespace sightline::accel::published::bvh {

using Lanes = float __attribute__((vector_size(16)));

/// The lesser number in each lane; where `a` is NaN, it is `b`.
inline Lanes least(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes greatest(Lanes a, Lanes b) { return a > b ? a : b; }

inline Lanes lanes(const geometry::Vec3f& v) { return Lanes{v.x, v.y, v.z, 0}; }
inline Lanes all_lanes(float x) { return Lanes{x, x, x, x}; }

/// A box in vector registers, empty by default.
struct LaneBox {
  Lanes lo = all_lanes(std::numeric_limits<float>::infinity());
  Lanes hi = all_lanes(-std::numeric_limits<float>::infinity());

  void grow(Lanes l, Lanes h) {
    lo = least(l, lo);
    hi = greatest(h, hi);
  }
  void grow(Lanes point) { grow(point, point); }
  void grow(const LaneBox& o) { grow(o.lo, o.hi); }

  geometry::Aabb aabb() const { return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}}; }
};

}  // namespace sightline::accel::published::bvh
