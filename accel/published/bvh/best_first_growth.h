// Grows a hierarchy when the budget does not suffice for all spatial splits: makes those that save
// most.
#pragma once

#include <cstddef>
#include <span>

#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/sweep_growth.h"

namespace sightline::accel::published::bvh {

/// Makes, among all open nodes, the spatial splits that save most compared with the object split,
/// per added reference; a few at a time, until `budget` references are added. A node whose split
/// would exceed the budget gets object splits only, and so do all nodes below it.
///
/// The cost of a split is the sum over both children of half area times references. Input and
/// touches are those of grow_by_sweep (sweep_growth.h). Parallel in the caller's arena; the result
/// does not depend on the number of threads. Throws std::bad_alloc.
BvhChild grow_best_first(const SplitSearch& search, const BvhLeafRule& leaf,
                         const CenterLists& root, std::size_t budget, BvhGrowth& growth,
                         kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
