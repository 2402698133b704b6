// Grows a hierarchy by binned splits. Source: Wald 2007, "On fast Construction of SAH-based
// Bounding Volume Hierarchies".
#pragma once

#include <cstdint>
#include <span>

#include "accel/published/bvh/bvh_growth.h"

namespace sightline::accel::published::bvh {

/// Splits each list at the boundary with the least SAH cost, among `bins` bins of equal width over
/// the centers of its boxes, on all three axes. Shorter lists have as many bins as references. A
/// list whose centers all coincide is halved in its order. `refs` is reordered to the order of the
/// leaves.
///
/// Touches: a pass to bin and a pass to divide each list. Parallel in the caller's arena; the
/// result does not depend on the number of threads.
BvhChild grow_binned(std::span<kdtree::Reference> refs, const BvhLeafRule& leaf, std::uint32_t bins,
                     BvhGrowth& growth, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
