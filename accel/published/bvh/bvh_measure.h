// What a hierarchy is like, in the metrics of all trees.
#pragma once

#include "accel/kdtree/tree_metrics.h"
#include "accel/published/bvh/bvh.h"

namespace sightline::accel::published::bvh {

/// As for kd-trees, with boxes for cells; a step here meets two boxes, there a plane. `overlap` is
/// the sum over inner nodes of SA(intersection of the children's boxes) / SA(root).
kdtree::TreeMetrics measure(const Bvh& bvh);

}  // namespace sightline::accel::published::bvh
