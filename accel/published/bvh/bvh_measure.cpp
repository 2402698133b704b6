// Walks a whole hierarchy to compute its metrics.
#include "accel/published/bvh/bvh_measure.h"

#include <algorithm>

#include "accel/published/bvh/box_overlap.h"

namespace sightline::accel::published::bvh {
namespace {

void measure_below(const Bvh& bvh, const BvhChild& at, int depth, double root_area,
                   kdtree::TreeMetrics& m) {
  const double share = root_area > 0 ? half_area(at.box) / root_area : 1;
  ++m.nodes;
  if (!at.inner) {
    ++m.leaves;
    m.nonempty_leaves += at.count > 0 ? 1 : 0;
    m.references += at.count;
    m.max_depth = std::max(m.max_depth, depth);
    m.expected_leaves += share;
    m.expected_intersections += share * at.count;
    return;
  }
  m.expected_traversals += share;
  const BvhNode& node = bvh.nodes[at.first];
  const BvhChild left = node.child(0), right = node.child(1);
  if (root_area > 0) m.overlap += common_half_area(left.box, right.box) / root_area;
  measure_below(bvh, left, depth + 1, root_area, m);
  measure_below(bvh, right, depth + 1, root_area, m);
}

}  // namespace

kdtree::TreeMetrics measure(const Bvh& bvh) {
  kdtree::TreeMetrics m;
  if (bvh.root.box.empty()) {  // and has no area: its bounds are infinite
    m.nodes = m.leaves = 1;
    return m;
  }
  const double root_area = half_area(bvh.root.box);
  measure_below(bvh, bvh.root, 0, root_area, m);
  m.sah_cost = kdtree::kMeasuredTraverse * m.expected_traversals +
               kdtree::kMeasuredIntersect * m.expected_intersections;
  m.bytes = bvh.bytes();
  return m;
}

}  // namespace sightline::accel::published::bvh
