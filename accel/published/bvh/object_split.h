// Object splits: a node's references are divided at an index of their order along an axis.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "accel/published/bvh/center_lists.h"

namespace sightline::accel::published::bvh {

/// The first `left` references along an axis go left. There is no split by default.
struct ObjectSplit {
  std::size_t axis = 0;
  std::size_t left = 0;
  /// Sum over both children of half area times references.
  double sum = std::numeric_limits<double>::infinity();

  bool found() const { return left > 0; }
};

/// Scratch memory of the sweep, per axis; kept for the next search.
using SweepAreas = std::array<std::vector<double>, 3>;

/// Returns the split of least sum among all on three axes; of equal ones the first along the first
/// axis. There is none for fewer than two references, or if no split has a smaller sum than the
/// whole list.
///
/// Source: Stich et al. 2009, section 2.1; Wald et al. 2007. Touches: two passes per axis.
ObjectSplit best_object_split(const CenterLists& lists, SweepAreas& areas,
                              kdtree::BuildCounters& counters);

/// Halves the list along the longest axis of its box. The list has at least two references.
ObjectSplit middle_split(const CenterLists& lists);

}  // namespace sightline::accel::published::bvh
