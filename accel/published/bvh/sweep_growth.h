// Grows a hierarchy by the SAH over all object splits, and over spatial splits where the rule
// allows.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/spatial_split.h"
#include "accel/published/bvh/split_search.h"

namespace sightline::accel::published::bvh {

/// The number of references that splits may add. Threads: any.
class ReferenceBudget {
 public:
  explicit ReferenceBudget(std::size_t most) : most_(most) {}

  /// Takes some of the budget; false, and exceeded(), if all together take more than there is.
  bool take(std::size_t references) {
    if (taken_.fetch_add(references, std::memory_order_relaxed) + references <= most_) return true;
    exceeded_.store(true, std::memory_order_relaxed);
    return false;
  }
  bool exceeded() const { return exceeded_.load(std::memory_order_relaxed); }

 private:
  std::size_t most_;
  std::atomic<std::size_t> taken_{0};
  std::atomic<bool> exceeded_{false};
};

class ListGrowth {
 public:
  /// If `budget` is null, there are object splits only. All arguments must outlive this.
  ListGrowth(const SplitSearch& search, const BvhLeafRule& leaf, BvhGrowth& growth,
             ReferenceBudget* budget)
      : search_(search), leaf_(leaf), growth_(growth), budget_(budget) {}

  /// Grows the subtree of a node, which is not usable once the budget is exceeded. Whether that
  /// happens depends on all nodes together, not on the order in which they grow. Reorders the
  /// lists.
  BvhChild grow(const CenterLists& node, int depth, SplitScratch& scratch,
                kdtree::BuildCounters& counters) const;

  /// Makes a leaf with ascending ids.
  BvhChild leaf(const CenterLists& node) const;

 private:
  BvhChild grow_children(const ListHalves& halves, int depth, SplitScratch& scratch,
                         kdtree::BuildCounters& counters) const;

  const SplitSearch& search_;
  const BvhLeafRule& leaf_;
  BvhGrowth& growth_;
  ReferenceBudget* budget_;
};

/// Whether a list becomes a leaf whatever a split costs.
inline bool is_leaf_unasked(std::size_t references, const BvhLeafRule& rule) {
  return references <= 1 || (references <= rule.leaf_size && !rule.split_small);
}

/// Capacity that grow_by_sweep needs in a BvhGrowth: twice the largest number of references,
/// because a hierarchy that exceeds the budget is grown again. Below 2^32.
std::size_t sweep_capacity(std::size_t references, const SpatialRule& spatial);

/// Splits each list at the index of least SAH cost in the order of its centers, on all three axes;
/// if the children overlap, at a plane if that costs less (`spatial`). Lists that neither can
/// separate are halved.
///
/// In: references of faces of `mesh`, fewer than 2^31; those of a face cover it together. If `mesh`
/// is null, there are no spatial splits, as with spatial.alpha = 1. Bounds went through widen_flat.
/// Out: nodes in `growth`, which has capacity for sweep_capacity(refs.size(), spatial).
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
