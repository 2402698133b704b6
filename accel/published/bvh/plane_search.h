// The cheapest plane to split a node by. Source: Stich et al. 2009, section 4.2.
#pragma once

#include <cstdint>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/chopped_axis.h"
#include "accel/published/bvh/fragment_corners.h"

namespace sightline::accel::published::bvh {

/// The cheapest of the bins - 1 planes along each axis that cut the node's box in equal parts, if
/// the sum is less than `below`; which of equal ones is a matter of their order. Not NaN: below.
///
/// Not all planes are weighed: a first pass finds what each side of every sixteenth plane has, and
/// sums between two of those cannot be less than what is left of the one and right of the other
/// have. Only where that is less than the best so far, all planes are weighed: differs from the
/// paper in the way, not in what is found.
///
/// `corners`: room, kept for the next search. Touches: a pass to begin with, and one for each
/// stretch that is looked at closely. Long lists are looked at in slices, at once.
SpatialSplit best_spatial_split(const geometry::MeshView& mesh, const CenterLists& node,
                                std::uint32_t bins, double below, ListCorners& corners,
                                kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
