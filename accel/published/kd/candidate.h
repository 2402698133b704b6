// Candidate splits of a cell, their cost, and their order: common to all exact builders. Source:
// Wald, Havran 2006, sections 3.1 to 3.5.
#pragma once

#include <cstdint>
#include <limits>
#include <tuple>

#include "accel/split/cost_model.h"

namespace sightline::accel::published::kd {

/// Cost constants in any unit; only ratios matter.
struct ExactCosts {
  double traverse = 1;     ///< K_T: visiting an inner node. Range 0 to 1e6.
  double intersect = 1.5;  ///< K_I: testing one unit of weight. Range 1e-6 to 1e6.
  double lambda =
      0.8;  ///< Factor on the total cost of a split with an empty side (eq. 7). Range 1e-6 to 1.

  bool operator==(const ExactCosts&) const = default;
};

/// A split, its cost and the weights of its sides. The lesser one in (cost, axis, position,
/// planar_left) is better: a total order, so that every search finds the same best candidate.
struct Candidate {
  double cost = std::numeric_limits<double>::infinity();
  kdtree::Split cut;
  std::uint32_t left = 0, right = 0;  ///< Weight of each side.

  bool operator<(const Candidate& o) const {
    return std::tie(cost, cut.plane.axis, cut.plane.position, cut.planar_left) <
           std::tie(o.cost, o.cut.plane.axis, o.cut.plane.position, o.cut.planar_left);
  }
};

/// The splits of one cell along one axis.
class AxisCuts {
 public:
  AxisCuts(const ExactCosts& costs, const geometry::Aabb& cell, int axis, std::uint32_t weight)
      : costs_(costs),
        areas_(cell, axis),
        lo_(cell.lo[static_cast<std::size_t>(axis)]),
        hi_(cell.hi[static_cast<std::size_t>(axis)]),
        flat_(hi_ <= geometry::least_above(lo_)),
        axis_(axis),
        weight_(weight) {}

  /// Whether x lies strictly inside the cell.
  bool inside(float x) const { return x > lo_ && x < hi_; }

  /// Whether a split makes progress. Inside the cell it must keep some reference out of one side.
  /// At a face of the cell it must move boxes that lie in the face into a flat cell (if lists are
  /// not clipped, with the boxes that reach beyond the face). A flat cell is not split along its
  /// flat axis.
  bool leads_somewhere(float x, bool planar_left, std::uint32_t left, std::uint32_t right) const {
    if (inside(x)) return left < weight_ || right < weight_;
    if (flat_) return false;
    return x == lo_ ? planar_left && right < weight_ : x == hi_ && !planar_left && left < weight_;
  }

  /// The cost (eq. 5 and 7), computed from integers, so that equal splits get equal bits.
  double cost(float x, std::uint32_t left, std::uint32_t right) const {
    constexpr double kNoBonus = 1;  // lambda is a factor on the whole cost
    const double children = areas_.children(static_cast<double>(x), left, right, kNoBonus);
    const double cost = costs_.traverse + costs_.intersect * children;
    return left == 0 || right == 0 ? cost * costs_.lambda : cost;
  }

  Candidate candidate(float x, bool planar_left, std::uint32_t left, std::uint32_t right) const {
    return {cost(x, left, right), {.plane = {axis_, x}, .planar_left = planar_left}, left, right};
  }

 private:
  const ExactCosts& costs_;
  split::SplitAreas areas_;
  float lo_, hi_;
  bool flat_;
  int axis_;
  std::uint32_t weight_;
};

}  // namespace sightline::accel::published::kd
