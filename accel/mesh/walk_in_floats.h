// One ray through the tree of a mesh: floats find what it may hit, and the leaf test decides.
#pragma once

#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/leaf_test.h"

namespace sightline::accel::mesh {

/// As lazy::walk_lazily(), for a tree that makes blocks. False: the ray begins too far away for
/// floats, and nothing was visited.
bool walk_in_floats(lazy::LazyTree& tree, LeafTest& test, kdtree::BuildCounters& built);

}  // namespace sightline::accel::mesh
