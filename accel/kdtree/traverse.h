// The traversal of a kd-tree by a ray: a ray prepared for one tree, its tests against boxes, and
// one loop for scene trees and mesh trees and for all kinds of query.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/geometry/intersect.h"
#include "accel/geometry/local_ray.h"
#include "accel/kdtree/deferred_cell.h"
#include "accel/kdtree/kd_tree.h"

namespace sightline::accel::kdtree {

/// Work done for rays, in the units of docs/benchmarks.md.
struct WalkCounters {
  std::uint64_t steps = 0;  ///< Inner nodes visited.
  std::uint64_t tests = 0;  ///< Triangles tested, scans of deferred cells included.
};

/// A ray prepared for one tree.
///
/// No cell with a hit is missed: a plane's t is computed with a relative error of 3 * 2^-53, a
/// hit's t with an error of kHitError times the distance, and `slack` is above both for any t
/// inside the tree's bounds. Intervals are only widened by it.
struct TreeRay {
  const geometry::LocalRay* local = nullptr;  ///< Must outlive this.
  geometry::Vec3d inverse;             ///< 1 / direction; infinite where the direction is zero.
  std::array<std::size_t, 3> first{};  ///< Child that the ray meets first along each axis.
  double slack = 0;
  double t_in = 0,
         t_out = 0;  ///< Interval of t inside both the bounds and the limits, widened by slack.
};

/// Prepares `out`. Returns false if the ray cannot meet the bounds between tmin and tmax (local
/// units).
inline bool enter(const geometry::LocalRay& ray, const geometry::Aabb& bounds, double tmin,
                  double tmax, TreeRay& out) {
  out.local = &ray;
  double distance = 0;
  double t_in = -std::numeric_limits<double>::infinity(),
         t_out = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < 3; ++a) {
    const double o = ray.origin[a], d = ray.direction[a];
    const double lo = static_cast<double>(bounds.lo[a]) - o,
                 hi = static_cast<double>(bounds.hi[a]) - o;
    distance = std::max(distance, std::max(std::fabs(lo), std::fabs(hi)));
    out.inverse[a] = 1 / d;
    out.first[a] = std::signbit(d) ? 1u : 0u;
    if (d == 0) {
      if (lo > 0 || hi < 0) return false;
      continue;
    }
    const double near = (out.first[a] == 1 ? hi : lo) * out.inverse[a],
                 far = (out.first[a] == 1 ? lo : hi) * out.inverse[a];
    t_in = std::max(t_in, near);
    t_out = std::min(t_out, far);
  }
  out.slack = distance * (4 * geometry::kHitError);
  out.t_in = std::max(t_in, tmin) - out.slack;
  out.t_out = std::min(t_out, tmax) + out.slack;
  return out.t_in <= out.t_out;
}

/// Whether the ray may meet a box between its t_in and `limit`; never false for a box that it
/// meets. For searching the lists of deferred cells.
inline bool may_meet(const TreeRay& ray, const geometry::Aabb& box, double limit) {
  double t_in = ray.t_in, t_out = std::min(ray.t_out, limit);
  for (std::size_t a = 0; a < 3; ++a) {
    const double lo = (static_cast<double>(box.lo[a]) - ray.local->origin[a]) * ray.inverse[a];
    const double hi = (static_cast<double>(box.hi[a]) - ray.local->origin[a]) * ray.inverse[a];
    const double near = (ray.first[a] == 1 ? hi : lo) - ray.slack,
                 far = (ray.first[a] == 1 ? lo : hi) + ray.slack;
    // A ray in the plane of a face has NaN here, which fails both tests.
    if (near > t_in) t_in = near;
    if (far < t_out) t_out = far;
  }
  return t_in <= t_out;
}

/// Visits, near to far, the cells that the ray enters.
///
/// `visit` supplies:
///   bool leaf(span<const uint32_t> references)          true: stop the walk
///   bool finished(const FinishedSubtree&)               true: stop the walk
///   DeferredAction deferred(AtomicSlot&, const DeferredCell&)   what to do at a deferred slot
///   double limit()                                      t beyond which nothing matters any more,
///                                                       widened by the slack
enum class DeferredAction {
  kRetry,  ///< The cell is built now: read the slot again.
  kDone,   ///< The cell is searched or skipped: continue with the next cell.
  kStop,   ///< Stop the traversal.
};

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
      if (slot.leaf_count() > 0 && visit.leaf(tree.leaf(slot, storage))) return;
    } else if (slot.is_finished()) {
      if (visit.finished(*slot.finished())) return;
    } else {
      const DeferredAction next = visit.deferred(*at, *slot.cell());
      if (next == DeferredAction::kRetry) continue;
      if (next == DeferredAction::kStop) return;
    }
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
