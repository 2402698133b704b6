// The first pass over a cell's list, made while the list is written: a cell's uniform planes are
// known before what lies in it is, so the sift of the cell above can count them.
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

/// The planes of a cell's first pass, on all three axes: n of them evenly from face to face, both
/// included; the last is repeated in unused places.
struct ChildPlanes {
  std::array<std::array<float, kdtree::kUniformPlanes>, 3> at;
};

/// n in 2 to kdtree::kUniformPlanes. A pure function of the cell.
ChildPlanes child_planes(const geometry::Aabb& cell, std::uint32_t n);

/// A cell's two halves: where the first pass over each of them counts, and what it counted.
struct ChildScans {
  ChildPlanes left_planes, right_planes;
  kdtree::ChildScan left, right;
};

/// As sift by {plane}, and adds to the scans what the first pass over what was written would find.
/// One touch a reference. Writes and counts the same on every SIMD target. May be called on one
/// piece of a list after the other, or with scans of their own on several at once.
kdtree::PartitionCounts sift_and_count(std::span<const kdtree::Reference> refs,
                                       const kdtree::Plane& plane, kdtree::Reference* left,
                                       kdtree::Reference* right, ChildScans& scans);

}  // namespace sightline::accel::split
