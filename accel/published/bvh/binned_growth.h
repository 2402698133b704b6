// Growing a hierarchy by binned splits. Source: Wald 2007, "On fast Construction of SAH-based
// Bounding Volume Hierarchies".
#pragma once

#include <cstdint>
#include <span>

#include "accel/published/bvh/bvh_growth.h"

namespace sightline::accel::published::bvh {

/// Splits each list where the surface area heuristic is least among the boundaries of `bins` bins
/// of equal width, over the centers of its boxes, on all three axes; lists shorter than that have
/// as many bins as references. Lists whose centers all coincide are halved as they stand. The list
/// is put in the order of the leaves.
///
/// Touches: a pass to bin and a pass to divide a list. Parallel in the caller's arena; the result
/// does not depend on it.
BvhChild grow_binned(std::span<kdtree::Reference> refs, const BvhLeafRule& leaf, std::uint32_t bins,
                     BvhGrowth& growth, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
