// Metrics of a tree, the same for all builders. Callers are pinned to an epoch.
#pragma once

#include <cstdint>

#include "accel/kdtree/kd_tree.h"

namespace sightline::accel::kdtree {

/// Cost constants of all metrics, also for trees of builders that used others (Wald, Havran 2006:
/// K_T = 1, K_I = 1.5).
inline constexpr double kMeasuredTraverse = 1;
inline constexpr double kMeasuredIntersect = 1.5;

/// Expected values are for a random line that meets the tree's bounds: sums of SA(cell) /
/// SA(bounds).
struct TreeMetrics {
  std::uint64_t nodes = 0;   ///< Inner nodes and leaves.
  std::uint64_t leaves = 0;  ///< Leaves, empty ones included.
  std::uint64_t nonempty_leaves = 0;
  std::uint64_t references = 0;  ///< References in all leaves, repeated ones included.
  int max_depth = 0;             ///< Largest depth of a leaf; 0 if the root is a leaf.
  std::uint64_t deferred_cells = 0;
  std::uint64_t failed_cells = 0;     ///< Cells of plain trees without room to divide them.
  double expected_traversals = 0;     ///< Inner nodes met (E_T).
  double expected_leaves = 0;         ///< Leaves met, empty ones included (E_L).
  double expected_intersections = 0;  ///< References in the leaves met (E_I).
  double sah_cost = 0;                ///< kMeasuredTraverse * E_T + kMeasuredIntersect * E_I.
  double overlap =
      0;  ///< Overlap of siblings' boxes (accel/published/bvh/bvh_measure.h); 0 for kd-trees.
  std::uint64_t bytes = 0;
  std::uint64_t bytes_peak = 0;  ///< The most bytes at any time, lists for building included.
};

TreeMetrics measure(const KdTree& tree);

/// How much of a lazy tree is built.
struct GrowthMetrics {
  std::uint64_t cells_built = 0;  ///< Inner nodes and leaves.
  std::uint64_t cells_deferred = 0;
  std::uint64_t references_built = 0;  ///< Distinct references in leaves.
};

/// Walks the tree. `ids` is greater than every reference id in it.
GrowthMetrics measure_growth(const KdTree& tree, std::uint64_t ids);

}  // namespace sightline::accel::kdtree
