// The traversal of a kd-tree by a ray: one loop for scene trees and mesh trees and for all kinds of
// query.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/kdtree/deferred_cell.h"
#include "accel/kdtree/kd_tree.h"
#include "accel/kdtree/tree_ray.h"
#include "accel/kdtree/walk_counters.h"

namespace sightline::accel::kdtree {

/// Visits, near to far, the cells that the ray enters.
///
/// `visit` supplies:
///   void leaf(span<const uint32_t> references)          a leaf that is not empty
///   void finished(const FinishedSubtree&)
///   bool deferred(AtomicSlot&, const DeferredCell&)     true: the slot has changed, read it again
///   bool is_done()                                      true: the walk ends
///   double limit()                                      t beyond which nothing matters any more,
///                                                       widened by the slack
template <class Visit>
void walk(const KdTree& tree, const TreeRay& ray, AtomicSlot& root, WalkCounters& counters,
          Visit& visit) {
  struct Waiting {
    AtomicSlot* slot;
    double t_in, t_out;
  };
  std::array<Waiting, kMaxTreeDepth + 2> stack;
  std::size_t waiting = 0;
  AtomicSlot* at = &root;
  double t_in = ray.t_in, t_out = ray.t_out;
  for (;;) {
    Slot slot = load(*at);
    while (slot.is_binary()) {
      ++counters.steps;
      const auto axis = static_cast<std::size_t>(slot.axis());
      const double t =
          (static_cast<double>(slot.position()) - ray.local->origin[axis]) * ray.inverse[axis];
      AtomicSlot* children = tree.children(slot);
      const std::size_t first = ray.first[axis];
      // A ray in the plane has t = NaN, which fails both tests: both sides are visited with the
      // whole interval.
      const bool skip_near = t + ray.slack < t_in;
      const bool skip_far = t - ray.slack > t_out;
      if (skip_near) {
        at = &children[1 - first];
      } else {
        at = &children[first];
        if (!skip_far) {
          stack[waiting++] = {&children[1 - first], t - ray.slack > t_in ? t - ray.slack : t_in,
                              t_out};
          if (t + ray.slack < t_out) t_out = t + ray.slack;
        }
      }
      slot = load(*at);
    }
    if (slot.is_leaf()) {
      std::uint32_t storage;
      if (slot.leaf_count() > 0) visit.leaf(tree.leaf(slot, storage));
    } else if (slot.is_finished()) {
      visit.finished(*slot.finished());
    } else if (visit.deferred(*at, *slot.cell())) {
      continue;
    }
    if (visit.is_done()) return;
    const double limit = visit.limit();
    do {
      if (waiting == 0) return;
      --waiting;
    } while (stack[waiting].t_in > limit);
    at = stack[waiting].slot;
    t_in = stack[waiting].t_in;
    t_out = stack[waiting].t_out;
  }
}

}  // namespace sightline::accel::kdtree
