// Splitting a node's references into those before and those after a place in their order.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "accel/published/bvh/center_lists.h"

namespace sightline::accel::published::bvh {

/// The first `left` along an axis go left. Made without arguments: none.
struct ObjectSplit {
  std::size_t axis = 0;
  std::size_t left = 0;
  /// Of half area times references, over both children.
  double sum = std::numeric_limits<double>::infinity();

  bool found() const { return left > 0; }
};

/// Areas met on the way, an axis; kept for the next search.
using SweepAreas = std::array<std::vector<double>, 3>;

/// The split of least sum among all, on all three axes; of equal ones the first along the first
/// axis. None for fewer than two references, or where none makes the sum less than it is for the
/// whole: nothing can be separated.
///
/// Source: Stich et al. 2009, section 2.1; Wald et al. 2007. Touches: two passes an axis.
ObjectSplit best_object_split(const CenterLists& lists, SweepAreas& areas,
                              kdtree::BuildCounters& counters);

/// Halves the list along the longest axis of its box. At least two references.
ObjectSplit middle_split(const CenterLists& lists);

}  // namespace sightline::accel::published::bvh
