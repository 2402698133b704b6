// Grows a hierarchy by the SAH over all object splits, and over spatial splits where the rule
// allows.
#pragma once

#include <cstddef>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/spatial_split.h"

namespace sightline::accel::published::bvh {

/// Capacity that grow_by_sweep needs in a BvhGrowth: twice the largest number of references,
/// because a hierarchy that exceeds the budget is grown again. Below 2^32.
std::size_t sweep_capacity(std::size_t references, const SpatialRule& spatial);

/// Splits each list at the index of least SAH cost in the order of its centers, on all three axes;
/// if the children overlap, at a plane if that costs less (`spatial`). Lists that neither can
/// separate are halved.
///
/// In: references of faces of `mesh`, fewer than 2^31; those of a face cover it together. `mesh`
/// null: no spatial splits, as with spatial.alpha = 1. Bounds went through widen_flat. Out: nodes
/// in `growth`, which has capacity for sweep_capacity(refs.size(), spatial).
///
/// Source: Stich, Friedrich, Dietrich 2009. Differs: the budget, and halving of lists that no split
/// separates. Touches: see best_object_split, divide_by_centers, best_spatial_split,
/// divide_by_plane; work dropped because the budget was exceeded is not counted, because it depends
/// on threads. Cost: O(n log n) time, up to 250 bytes per reference while it grows. Parallel in the
/// caller's arena; the result does not depend on the number of threads. Throws std::bad_alloc.
BvhChild grow_by_sweep(const geometry::MeshView* mesh, std::vector<kdtree::Reference> refs,
                       const BvhLeafRule& leaf, const SpatialRule& spatial, BvhGrowth& growth,
                       kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
