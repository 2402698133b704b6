// Eager growth: from one cell's list to its finished subtree.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/kd_tree.h"
#include "accel/split/split_search.h"

namespace sightline::accel::grow {

/// What a growth needs besides its cell.
struct GrowContext {
  kdtree::KdTree& tree;
  const split::SplitSearch& rule;
  const geometry::MeshView* mesh =
      nullptr;  ///< What clipping builders clip; null: nothing to clip.
  int max_depth = 0;
  /// Once true, large cells not begun yet are left deferred (kForkFrom references or more).
  const std::atomic<bool>* cancelled = nullptr;
};

/// Depth beyond which no cell of a tree over this many references is cut: 8 + 1.3 log2 n is the
/// depth of a good tree (Havran 2000), the rest is room for cutting off empty space.
int depth_limit(std::size_t references);

/// The same, or less where the rule has a bound of its own (`depth_bound`).
int depth_limit(const split::SplitSearch& rule, std::size_t references);

/// Grows the subtree under `cell` and returns its slot, not yet published anywhere. The list is
/// used up: the left child overwrites its parent's, the right child's comes from a stack (Hunt et
/// al. 2006, section 6.3.1). Large subtrees become tasks in the caller's arena. A cell for which
/// there is no room stays deferred, given up. Throws std::bad_alloc; whatever was grown until then
/// stays unreachable in the tree's storage.
///
/// A rule may grow subtrees in its own way (SplitSearch::grow_subtree).
kdtree::Slot grow(const GrowContext& context, std::span<kdtree::Reference> refs,
                  const geometry::Aabb& cell, const kdtree::CellPath& path,
                  kdtree::BuildCounters& counters);

}  // namespace sightline::accel::grow
