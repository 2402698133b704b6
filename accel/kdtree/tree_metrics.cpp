// Walks whole trees to compute their metrics.
#include "accel/kdtree/tree_metrics.h"

#include <algorithm>
#include <vector>

namespace sightline::accel::kdtree {
namespace {

void measure_below(const KdTree& tree, Slot slot, const geometry::Aabb& cell, int depth,
                   double root_area, TreeMetrics& m) {
  const double share = root_area > 0 ? half_area(cell) / root_area : 1;
  if (slot.is_deferred()) {
    ++m.deferred_cells;
    m.failed_cells += slot.cell()->failed.load(std::memory_order_relaxed) ? 1 : 0;
    return;
  }
  if (slot.is_finished()) return slot.finished()->measure(root_area, depth, m);
  ++m.nodes;
  if (slot.is_leaf()) {
    ++m.leaves;
    m.nonempty_leaves += slot.leaf_count() > 0 ? 1 : 0;
    m.references += slot.leaf_count();
    m.max_depth = std::max(m.max_depth, depth);
    m.expected_leaves += share;
    m.expected_intersections += share * slot.leaf_count();
    return;
  }
  m.expected_traversals += share;
  const geometry::HalvedCell halves = halve(cell, slot.axis(), slot.position());
  const AtomicSlot* children = tree.children(slot);
  measure_below(tree, load(children[0]), halves.left, depth + 1, root_area, m);
  measure_below(tree, load(children[1]), halves.right, depth + 1, root_area, m);
}

void grow_below(const KdTree& tree, Slot slot, std::vector<bool>& seen, GrowthMetrics& g) {
  if (slot.is_deferred()) {
    ++g.cells_deferred;
    return;
  }
  if (slot.is_finished()) return slot.finished()->measure_growth(seen, g);
  ++g.cells_built;
  if (slot.is_leaf()) {
    if (slot.leaf_count() == 0) return;
    std::uint32_t storage;
    for (const std::uint32_t id : tree.leaf(slot, storage)) {
      if (seen[id]) continue;
      seen[id] = true;
      ++g.references_built;
    }
    return;
  }
  const AtomicSlot* children = tree.children(slot);
  grow_below(tree, load(children[0]), seen, g);
  grow_below(tree, load(children[1]), seen, g);
}

}  // namespace

TreeMetrics measure(const KdTree& tree) {
  TreeMetrics m;
  measure_below(tree, load(tree.root()), tree.bounds(), 0, half_area(tree.bounds()), m);
  m.sah_cost =
      kMeasuredTraverse * m.expected_traversals + kMeasuredIntersect * m.expected_intersections;
  m.bytes = tree.bytes();
  m.bytes_peak = tree.bytes_peak();
  return m;
}

GrowthMetrics measure_growth(const KdTree& tree, std::uint64_t ids) {
  GrowthMetrics g;
  const Slot root = load(tree.root());
  // An untouched tree needs no bit for each reference.
  std::vector<bool> seen(root.is_deferred() ? 0 : ids);
  grow_below(tree, root, seen, g);
  return g;
}

}  // namespace sightline::accel::kdtree
