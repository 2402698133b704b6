// The first pass over a cell's list, made while the list is written. The planes of that pass depend
// on the cell's box alone, so the sift of its parent's list can count at them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/kdtree/plane_counts.h"
#include "accel/kdtree/reference.h"
#include "accel/kdtree/sift.h"
#include "accel/split/scan_kernel.h"

namespace sightline::accel::split {

/// The planes of a cell's first pass on three axes: n evenly spaced planes from face to face, both
/// faces included. The last plane fills unused entries.
struct ChildPlanes {
  std::array<std::array<float, kdtree::kUniformPlanes>, 3> at;
};

/// Returns the planes of a cell's first pass. n: 2 to kdtree::kUniformPlanes.
ChildPlanes child_planes(const geometry::Aabb& cell, std::uint32_t n);

/// The planes and the counts of the first pass over each child of a cell.
struct ChildScans {
  ChildPlanes left_planes, right_planes;
  kdtree::ChildScan left, right;
};

/// Sifts by the plane (kdtree::sift), and adds to `scans` the counts of the first passes over the
/// written lists. Touches: one per reference. The result is the same on every SIMD target. May be
/// called for one piece of a list after the other, or for several at once with separate scans.
kdtree::PartitionCounts sift_and_count(std::span<const kdtree::Reference> refs,
                                       const kdtree::Plane& plane, kdtree::Reference* left,
                                       kdtree::Reference* right, ChildScans& scans);

}  // namespace sightline::accel::split
