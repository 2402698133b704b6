// Sifting a cell's list into its halves, now or later, all of it or a slice.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference_list.h"
#include "accel/split/child_scan.h"
#include "accel/split/kd_builder.h"

namespace sightline::accel {

/// What sifting needs to know of a cell; owns it, so that it may be done late.
struct Sieve {
  KdBuilder builder;
  std::optional<MeshView> clipped;  ///< What straddlers are clipped against, if they are.
  Cut cut;
  CellPath path;
  HalvedCell halves;
  bool scans;          ///< The children's lists are scanned meanwhile.
  bool openable;       ///< Straddlers that can be opened are to be counted.
  bool whole = false;  ///< The list comes in one piece: whether it is a crowd can be told.
};

/// References on both sides of a plane.
struct Straddling {
  std::size_t openable = 0, all = 0;
};

struct Sides {
  BoxList left, right;
  FirstScan left_scan, right_scan;
  Straddling straddling;  ///< Before clipping.
};

/// `size`: of all spans together. Throws std::bad_alloc.
Sides sift_spans(const Sieve& sieve, std::span<const std::span<const BoxRef>> spans,
                 std::size_t size, BuildCounters& counters);

/// A thread's own room for so many boxes, until it asks again: lists are made there, and allocated
/// at the length they come to. Throws std::bad_alloc.
std::span<BoxRef> scratch(std::size_t size);

}  // namespace sightline::accel
