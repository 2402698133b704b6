// Vectors of three numbers of 113 bits, in which the oracle decides hits.
#pragma once

#include "accel/geometry/vec3.h"
#include "scenegraph/model/affine.h"

namespace sightline::tests {

__extension__ using Quad = __float128;
using QuadVec = accel::geometry::Vec3<Quad>;

inline QuadVec widen(const accel::geometry::Vec3d& v) { return {v.x, v.y, v.z}; }
inline Quad absolute(Quad x) { return x < 0 ? -x : x; }

/// A point transformed by a double matrix; the error is at most a few units in the 113th bit.
inline QuadVec transform(const scenegraph::model::Affine& a, const accel::geometry::Vec3f& p) {
  const auto row = [&](std::size_t r) {
    return Quad{a.m[r]} * static_cast<Quad>(p.x) + Quad{a.m[r + 1]} * static_cast<Quad>(p.y) +
           Quad{a.m[r + 2]} * static_cast<Quad>(p.z) + Quad{a.m[r + 3]};
  };
  return {row(0), row(4), row(8)};
}

}  // namespace sightline::tests
