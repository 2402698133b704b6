// Points on which searches for the closest face fail: on faces, edges and corners and just beside
// them, equally far from many faces, on planes of cells, and far away.
#pragma once

#include <cstdint>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::tests {

/// The number of kinds that hard_points cycles through.
inline constexpr std::size_t kHardPointKinds = 14;

/// Cycles through the kinds: near the surface (by 1 % of the diagonal), in 1.2 times the box, 10
/// and 1e9 diagonals away; corners, corners off by an ulp of a double and of a float, midpoints of
/// edges, centers of faces, those off by an ulp of a double and of a float; on the plane between
/// two faces; circumcenters and centers of meshes; on planes and edges of boxes. All are finite.
/// Without a finite face there are none.
std::vector<accel::geometry::Vec3d> hard_points(const scenegraph::revision::Snapshot& snapshot,
                                                std::uint64_t seed, std::size_t count);

}  // namespace sightline::tests
