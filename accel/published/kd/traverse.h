// The traversal of a plain kd-tree by a ray.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/kdtree/kd_tree.h"
#include "accel/kdtree/tree_ray.h"
#include "accel/kdtree/walk_counters.h"
#include "accel/published/kd/plain_cells.h"

namespace sightline::accel::published::kd {

/// The far side of a node that was entered, and the ray's interval there.
struct WaitingCell {
  PlainNode node;
  double t_in, t_out;
};

/// Visits, near to far, the leaves that the ray enters.
///
/// `visit` supplies:
///   bool leaf(span<const uint32_t> references)          true: stop the walk
///   bool references(span<const Reference>)              the same for a leaf that failed
///   double limit()                                      t beyond which nothing matters any more,
///                                                       widened by the slack
template <class Visit>
void walk(const PlainCells& cells, const kdtree::TreeRay& ray, kdtree::WalkCounters& counters,
          Visit& visit) {
  std::array<WaitingCell, kdtree::kMaxTreeDepth + 2> stack;
  std::size_t waiting = 0;
  WaitingCell at{cells.root, ray.t_in, ray.t_out};
  for (;;) {
    while (!at.node.is_leaf()) {
      ++counters.steps;
      const std::size_t axis = at.node.axis(), first = ray.first[axis];
      const double t =
          (static_cast<double>(at.node.position()) - ray.local->origin[axis]) * ray.inverse[axis];
      const PlainCells::Pair& children = cells.pairs[at.node.pair()];
      // A ray in the plane has t = NaN, which fails both tests: both sides are visited with the
      // whole interval.
      const bool skip_near = t + ray.slack < at.t_in;
      const bool skip_far = t - ray.slack > at.t_out;
      at.node = children[skip_near ? 1 - first : first];
      if (skip_near || skip_far) continue;
      stack[waiting++] = {children[1 - first], t - ray.slack > at.t_in ? t - ray.slack : at.t_in,
                          at.t_out};
      if (t + ray.slack < at.t_out) at.t_out = t + ray.slack;
    }
    if (at.node.count() > 0) {
      std::uint32_t storage;
      if (at.node.is_failed() ? visit.references(cells.failed_leaf(at.node))
                              : visit.leaf(cells.leaf(at.node, storage)))
        return;
    }
    const double limit = visit.limit();
    do {
      if (waiting == 0) return;
      --waiting;
    } while (stack[waiting].t_in > limit);
    at = stack[waiting];
  }
}

}  // namespace sightline::accel::published::kd
