// Splits of short lists: every bound of a box is a candidate, and all are counted in one pass.
// Source: Hunt, Mark, Stoll 2006, section 6.2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "accel/kdtree/reference.h"
#include "accel/split/cost_model.h"
#include "accel/split/scan_kernel.h"

namespace sightline::accel::split {

/// How a short list is split: at the best bound strictly inside the cell, if that is cheaper than a
/// leaf. The best has the least cost, then the least axis, then the least position.
struct BoundRule {
  SahConstants cost;
  /// Lists of at most this length try all axes, longer ones the longest axis of the cell.
  std::size_t all_axes_up_to = std::numeric_limits<std::size_t>::max();
  /// If the longest axis has no split below this share of the leaf's cost, the other two axes are
  /// tried, too. Infinite: never.
  double retry_above = std::numeric_limits<double>::infinity();
};

/// Longest list that choose_bound takes.
inline constexpr std::size_t kMaxBoundScan = 256;

/// The split of the rule, or nothing for a leaf. It is the same on every SIMD target. refs: 1 to
/// kMaxBoundScan. Touches: a pass over the list for every kScanWidth candidates of an axis.
std::optional<kdtree::Split> choose_bound(std::span<const kdtree::Reference> refs,
                                          const geometry::Aabb& cell, const BoundRule& rule,
                                          kdtree::BuildCounters& counters);

/// The best of the bounds strictly inside a cell.
struct BoundSplit {
  kdtree::Plane plane;
  /// Cost of the two children in units of weight, relative to the cell's area; infinite if no
  /// bound lies inside.
  float children = std::numeric_limits<float>::infinity();

  bool found() const { return children < std::numeric_limits<float>::infinity(); }
  double cost(const SahConstants& c) const {
    return c.traverse + c.intersect * static_cast<double>(children);
  }
  void offer(const BoundSplit& other) {
    if (other.children < children) *this = other;
  }
};

/// Tries axes in the order of the rule. `best_of(AxisRange)` returns the best split on those axes.
template <class BestOf>
BoundSplit best_bound(const BoundRule& rule, const geometry::Aabb& cell, std::size_t size,
                      double weight, const BestOf& best_of) {
  if (!(rule.cost.traverse < rule.cost.intersect * weight)) return {};  // a leaf costs no more
  if (size <= rule.all_axes_up_to) return best_of(AxisRange{});
  const int longest = longest_axis(cell);
  BoundSplit best = best_of(AxisRange{longest, longest + 1});
  const bool may_retry = rule.retry_above < std::numeric_limits<double>::infinity();
  if (may_retry && !(best.cost(rule.cost) < rule.retry_above * rule.cost.intersect * weight)) {
    for (const int axis : {(longest + 1) % 3, (longest + 2) % 3})
      best.offer(best_of(AxisRange{axis, axis + 1}));
  }
  return best;
}

}  // namespace sightline::accel::split
