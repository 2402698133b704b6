// The boxes of the cells of a lazy tree that are not built yet.
#pragma once

#include <functional>

#include "accel/geometry/aabb.h"
#include "accel/kdtree/kd_tree.h"

namespace sightline::accel::kdtree {

/// Passes the box of every deferred cell, in the tree's coordinates. Walks what is built. Callers
/// are pinned to an epoch.
void for_each_deferred_box(const KdTree& tree,
                           const std::function<void(const geometry::Aabb&)>& pass);

}  // namespace sightline::accel::kdtree
