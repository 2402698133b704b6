// Walks whole trees to compute their metrics.
#include "accel/kdtree/tree_metrics.h"

#include <algorithm>
#include <vector>

namespace sightline::accel::kdtree {
namespace {

/// Adds the metrics of the tree below a slot, whose box is `box`.
void measure_below(Slot slot, const geometry::Aabb& box, int depth, double root_area,
                   TreeMetrics& m) {
  if (!slot) return;
  if (slot.is_deferred()) {
    ++m.deferred_cells;
    return;
  }
  if (slot.is_finished()) return slot.finished()->measure(root_area, depth, m);
  ++m.nodes;
  if (slot.is_list()) {  // which is empty
    ++m.leaves;
    return;
  }
  m.expected_traversals += root_area > 0 ? half_area(box) / root_area : 1;
  const WideNode& node = *slot.node();
  for (std::size_t i = 0; i < kWidth; ++i)
    measure_below(node.child(i), node.box(i), depth + 1, root_area, m);
}

void grow_below(Slot slot, std::vector<bool>& seen, GrowthMetrics& g) {
  if (!slot) return;
  if (slot.is_deferred()) {
    ++g.cells_deferred;
    return;
  }
  if (slot.is_finished()) return slot.finished()->measure_growth(seen, g);
  ++g.cells_built;
  if (slot.is_list()) return;
  for (const AtomicSlot& child : slot.node()->children) grow_below(load(child), seen, g);
}

}  // namespace

TreeMetrics measure(const KdTree& tree) {
  TreeMetrics m;
  measure_below(load(tree.root()), tree.bounds(), 0, half_area(tree.bounds()), m);
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
  grow_below(root, seen, g);
  return g;
}

}  // namespace sightline::accel::kdtree
