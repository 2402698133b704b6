// Sifts a cell's list into its halves, whole or slice by slice.
#pragma once

#include <cstddef>
#include <span>

#include "accel/grow/cell_cut.h"
#include "accel/kdtree/reference_list.h"
#include "accel/split/split_search.h"

namespace sightline::accel::lazy {

/// A cut to be made, and what keeps it valid: it may be done late.
struct PartitionInput {
  split::SplitRule rule;
  grow::CellCut cut;
  bool openable;  ///< Straddlers that can be opened are to be counted.
};

/// References on both sides of a plane.
struct Straddling {
  std::size_t openable = 0, all = 0;
};

struct PartitionResult {
  kdtree::ReferenceList left, right;
  kdtree::ChildScan left_scan, right_scan;
  Straddling straddling;  ///< Before clipping.
};

/// `size`: of all spans together. Throws std::bad_alloc.
PartitionResult sift_spans(const PartitionInput& input,
                           std::span<const std::span<const kdtree::Reference>> spans,
                           std::size_t size, kdtree::BuildCounters& counters);

/// A buffer of the calling thread for `size` boxes, valid until its next call: lists are made there
/// and then copied at their true length. Throws std::bad_alloc.
std::span<kdtree::Reference> scratch(std::size_t size);

}  // namespace sightline::accel::lazy
