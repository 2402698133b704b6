// The cheapest plane to split a node by. Source: Stich et al. 2009, section 4.2.
#pragma once

#include <cstdint>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/spatial_bins.h"

namespace sightline::accel::published::bvh {

/// Returns the cheapest of the bins - 1 planes along each axis that cut the node's box in equal
/// parts, if its sum is less than `below`. Among planes of equal sum the search order decides.
/// `below`: not NaN.
///
/// A first pass computes the sides of kMostBins coarse bins. The sum of a plane between two coarse
/// planes is at least cost_left(first) + cost_right(second), so most intervals are skipped, and
/// only the others get a pass over all their planes. The planes found are those of the paper.
///
/// `corners`: scratch memory, kept for the next search. Touches: the first pass, and one for each
/// refined interval. Long lists are scanned in parallel slices.
SpatialSplit best_spatial_split(const geometry::MeshView& mesh, const CenterLists& node,
                                std::uint32_t bins, double below, ListCorners& corners,
                                kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
