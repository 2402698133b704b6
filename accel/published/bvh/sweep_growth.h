// Growing a hierarchy by the surface area heuristic over all splits, spatial ones included.
#pragma once

#include <cstddef>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/spatial_split.h"

namespace sightline::accel::published::bvh {

/// How many references a BvhGrowth must have room for, to grow over so many by sweeping: twice as
/// many as there may be, as what comes to exceed the budget is grown again. Below 2^32.
std::size_t sweep_capacity(std::size_t references, const SpatialRule& spatial);

/// Splits each list where the surface area heuristic is least among all places in the order of its
/// centers, on all three axes; where the children then overlap, at a plane if that costs less
/// (`spatial`). Lists that neither can separate are halved.
///
/// In: faces of `mesh`, fewer than 2^31, a face's references holding all of it together; `mesh`
/// null: no spatial splits, as with spatial.alpha = 1. Bounds went through widen_flat.
/// Out: what is in `growth`, which has room for sweep_capacity(refs.size(), spatial).
///
/// Source: Stich, Friedrich, Dietrich 2009; differs: the budget, and what no split separates.
/// Touches: see best_object_split, divide_by_centers, best_spatial_split, divide_by_plane; work
/// that is dropped because the budget does not suffice is not counted, as it depends on threads.
/// Cost: O(n log n), and up to 250 bytes a reference while it grows. Parallel in the caller's
/// arena; the result does not depend on it. Throws std::bad_alloc.
BvhChild grow_by_sweep(const geometry::MeshView* mesh, std::vector<kdtree::Reference> refs,
                       const BvhLeafRule& leaf, const SpatialRule& spatial, BvhGrowth& growth,
                       kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
