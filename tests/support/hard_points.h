// Points on which searches for the closest face fail: on faces, edges and corners and just beside
// them, equally far from many faces, on planes of cells, and far away.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "scenegraph/revision/snapshot.h"
#include "tests/support/random.h"

namespace sightline::tests {

/// The number of kinds that hard_points cycles through.
inline constexpr std::size_t kHardPointKinds = 14;

/// Each coordinate moves down, up or not at all, to the next number of type T.
template <class T>
accel::geometry::Vec3d beside(const accel::geometry::Vec3d& p, Random& random) {
  accel::geometry::Vec3d moved;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto from = static_cast<T>(p[axis]);
    const std::uint64_t way = random.below(3);
    const auto toward = static_cast<T>(way == 1 ? HUGE_VAL : -HUGE_VAL);
    moved[axis] = static_cast<double>(way == 0 ? from : std::nextafter(from, toward));
  }
  return moved;
}

/// Cycles through the kinds: near the surface (by 1 % of the diagonal), in 1.2 times the box, 10
/// and 1e9 diagonals away; corners, corners off by an ulp of a double and of a float, midpoints of
/// edges, centers of faces, those off by an ulp of a double and of a float; on the plane between
/// two faces; circumcenters and centers of meshes; on planes and edges of boxes. All are finite.
/// Without a finite face there are none.
std::vector<accel::geometry::Vec3d> hard_points(const scenegraph::revision::Snapshot& snapshot,
                                                std::uint64_t seed, std::size_t count);

}  // namespace sightline::tests
