// Metrics of a plain kd-tree, in the form of all trees.
#pragma once

#include "accel/kdtree/tree_metrics.h"
#include "accel/published/kd/plain_cells.h"

namespace sightline::accel::published::kd {

/// Computes the metrics of a tree. `bounds` is the cell of the root. Failed leaves count as
/// deferred and failed cells, and nowhere else.
kdtree::TreeMetrics measure(const PlainCells& cells, const geometry::Aabb& bounds);

}  // namespace sightline::accel::published::kd
