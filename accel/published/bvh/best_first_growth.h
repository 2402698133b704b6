// Growing a hierarchy where not all spatial splits can be paid for: those that gain most are made.
#pragma once

#include <cstddef>
#include <span>

#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/list_growth.h"

namespace sightline::accel::published::bvh {

/// Splits first, among all nodes there are, those whose spatial split saves most over their object
/// split, for each reference that it adds; a few at a time, until `budget` references were added.
/// A node whose split would add more than is left, and all below it, get object splits.
///
/// Saved is the sum of half area times references over both children. In, touches: as
/// grow_by_sweep (sweep_growth.h). Parallel in the caller's arena; the result does not depend on
/// it. Throws std::bad_alloc.
BvhChild grow_best_first(const SplitSearch& search, const BvhLeafRule& leaf,
                         const CenterLists& root, std::size_t budget, BvhGrowth& growth,
                         kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
