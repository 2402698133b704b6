// Sifting a cell's list into its halves, now or later, all of it or a slice.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference_list.h"
#include "accel/split/child_scan.h"
#include "accel/split/split_search.h"

namespace sightline::accel::lazy {

/// What sifting needs to know of a cell; owns it, so that it may be done late.
struct Sieve {
  split::SplitRule rule;
  std::optional<geometry::MeshView> clipped;  ///< What straddlers are clipped against, if they are.
  kdtree::Cut cut;
  geometry::HalvedCell halves;
  bool scans;          ///< The children's lists are scanned meanwhile.
  bool openable;       ///< Straddlers that can be opened are to be counted.
  bool whole = false;  ///< The list comes in one piece: whether it is a crowd can be told.
};

/// References on both sides of a plane.
struct Straddling {
  std::size_t openable = 0, all = 0;
};

struct Sides {
  kdtree::BoxList left, right;
  kdtree::FirstScan left_scan, right_scan;
  Straddling straddling;  ///< Before clipping.
};

/// `size`: of all spans together. Throws std::bad_alloc.
Sides sift_spans(const Sieve& sieve, std::span<const std::span<const kdtree::BoxRef>> spans,
                 std::size_t size, kdtree::BuildCounters& counters);

/// A thread's own room for so many boxes, until it asks again: lists are made there, and allocated
/// at the length they come to. Throws std::bad_alloc.
std::span<kdtree::BoxRef> scratch(std::size_t size);

}  // namespace sightline::accel::lazy
