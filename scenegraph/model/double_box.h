// An axis-aligned box in double.
#pragma once

#include <algorithm>
#include <cstddef>

#include "accel/geometry/aabb.h"
#include "accel/geometry/ray.h"
#include "scenegraph/model/affine.h"

namespace sightline::scenegraph::model {

struct DoubleBox {
  Vec3d lo{accel::geometry::kInfinity, accel::geometry::kInfinity, accel::geometry::kInfinity};
  Vec3d hi{-accel::geometry::kInfinity, -accel::geometry::kInfinity, -accel::geometry::kInfinity};

  DoubleBox() = default;
  explicit DoubleBox(const accel::geometry::Aabb& b) : lo(b.lo), hi(b.hi) {}

  bool operator==(const DoubleBox&) const = default;
  bool empty() const { return !(lo.x <= hi.x); }

  void grow(const Vec3d& p) {
    for (std::size_t a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], p[a]);
      hi[a] = std::max(hi[a], p[a]);
    }
  }
};

/// The bounds of the eight corners, each mapped by a.point(). The box is not empty.
inline DoubleBox mapped(const Affine& a, const DoubleBox& box) {
  DoubleBox r;
  for (std::size_t row = 0; row < 3; ++row) {
    // Rounding is monotonic: the least sum is that of the least terms.
    const double* m = &a.m[4 * row];
    const double x0 = m[0] * box.lo.x, x1 = m[0] * box.hi.x;
    const double y0 = m[1] * box.lo.y, y1 = m[1] * box.hi.y;
    const double z0 = m[2] * box.lo.z, z1 = m[2] * box.hi.z;
    r.lo[row] = std::min(x0, x1) + std::min(y0, y1) + std::min(z0, z1) + m[3];
    r.hi[row] = std::max(x0, x1) + std::max(y0, y1) + std::max(z0, z1) + m[3];
  }
  return r;
}

/// The box, larger by `pad` on every side.
inline DoubleBox padded(const DoubleBox& box, double pad) {
  DoubleBox r = box;
  r.lo = box.lo - Vec3d{pad, pad, pad};
  r.hi = box.hi + Vec3d{pad, pad, pad};
  return r;
}

}  // namespace sightline::scenegraph::model
