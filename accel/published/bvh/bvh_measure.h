// Metrics of a hierarchy, in the form of all trees.
#pragma once

#include "accel/kdtree/tree_metrics.h"
#include "accel/published/bvh/bvh.h"

namespace sightline::accel::published::bvh {

/// Computes the metrics of kd-trees, with boxes instead of cells. A step tests two boxes, in a
/// kd-tree one plane. `overlap` is the sum over inner nodes of SA(intersection of the children's
/// boxes) / SA(root).
kdtree::TreeMetrics measure(const Bvh& bvh);

}  // namespace sightline::accel::published::bvh
