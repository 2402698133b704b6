// Walks a whole plain tree to compute its metrics.
#include "accel/published/kd/plain_measure.h"

#include <algorithm>

namespace sightline::accel::published::kd {
namespace {

void measure_below(const PlainCells& cells, PlainNode node, const geometry::Aabb& cell, int depth,
                   double root_area, kdtree::TreeMetrics& m) {
  if (node.is_failed()) {
    ++m.deferred_cells;
    ++m.failed_cells;
    return;
  }
  const double share = root_area > 0 ? half_area(cell) / root_area : 1;
  ++m.nodes;
  if (node.is_leaf()) {
    ++m.leaves;
    m.nonempty_leaves += node.count() > 0 ? 1 : 0;
    m.references += node.count();
    m.max_depth = std::max(m.max_depth, depth);
    m.expected_leaves += share;
    m.expected_intersections += share * node.count();
    return;
  }
  m.expected_traversals += share;
  const geometry::HalvedCell halves =
      geometry::halve(cell, static_cast<int>(node.axis()), node.position());
  const auto& [left, right] = cells.pairs[node.pair()];
  measure_below(cells, left, halves.left, depth + 1, root_area, m);
  measure_below(cells, right, halves.right, depth + 1, root_area, m);
}

}  // namespace

kdtree::TreeMetrics measure(const PlainCells& cells, const geometry::Aabb& bounds) {
  kdtree::TreeMetrics m;
  m.bytes = cells.bytes();
  if (bounds.empty()) {  // and has no area: it is infinite
    m.nodes = m.leaves = 1;
    return m;
  }
  measure_below(cells, cells.root, bounds, 0, half_area(bounds), m);
  m.sah_cost = kdtree::kMeasuredTraverse * m.expected_traversals +
               kdtree::kMeasuredIntersect * m.expected_intersections;
  return m;
}

}  // namespace sightline::accel::published::kd
