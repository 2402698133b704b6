// Grows a hierarchy from sorted lists, depth first.
#pragma once

#include <atomic>
#include <cstddef>

#include "accel/published/bvh/bvh_growth.h"
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
  /// `budget` null: object splits only. All arguments must outlive this.
  ListGrowth(const SplitSearch& search, const BvhLeafRule& leaf, BvhGrowth& growth,
             ReferenceBudget* budget)
      : search_(search), leaf_(leaf), growth_(growth), budget_(budget) {}

  /// The subtree of a node; not usable once the budget is exceeded. Whether that happens depends on
  /// all nodes together, not on the order in which they grow. Reorders the lists.
  BvhChild grow(const CenterLists& node, int depth, SplitScratch& scratch,
                kdtree::BuildCounters& counters) const;

  /// A leaf, ids ascending.
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

}  // namespace sightline::accel::published::bvh
