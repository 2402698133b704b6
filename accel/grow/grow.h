// Eager growth: from one cell's list to its finished subtree.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/kd_tree.h"
#include "accel/split/split_search.h"

namespace sightline::accel::grow {

/// What eager growth needs besides the cell.
struct GrowContext {
  kdtree::KdTree& tree;
  const split::SplitSearch& rule;
  const geometry::MeshView* mesh =
      nullptr;  ///< What straddlers are clipped against; null: references are not triangles.
  int max_depth = 0;
  /// Once it is true, large cells (kForkFrom references or more) that are not begun stay deferred.
  const std::atomic<bool>* cancelled = nullptr;
};

/// Depth beyond which no cell of a tree over this many references is cut: 8 + 1.3 log2 n is the
/// depth of a good tree (Havran 2000); the rest allows for cuts that only remove empty space.
int depth_limit(std::size_t references);

/// The same, or the rule's own bound (`depth_bound`) if that is less.
int depth_limit(const split::SplitSearch& rule, std::size_t references);

/// Grows the subtree under `cell` and returns its slot, which is not published yet. The list is
/// overwritten: the left child's list takes the place of its parent's, the right child's is on a
/// stack (Hunt et al. 2006, section 6.3.1). Large subtrees become tasks in the caller's arena. A
/// cell for which there is no room stays deferred and given up. Throws std::bad_alloc; the part
/// grown until then stays unreachable in the tree's storage.
///
/// A rule may grow subtrees in its own way (SplitSearch::grow_subtree).
kdtree::Slot grow(const GrowContext& context, std::span<kdtree::BoxRef> refs,
                  const geometry::Aabb& cell, const kdtree::CellPath& path,
                  kdtree::BuildCounters& counters);

}  // namespace sightline::accel::grow
