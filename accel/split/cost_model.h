// The surface area heuristic (SAH) for one cell, as a function of the position of the split.
// Source: Hunt et al. 2006, section 2.
#pragma once

#include <cstdint>

#include "accel/kdtree/reference.h"

namespace sightline::accel::split {

/// Cost constants of a method, in units of one triangle test.
struct SahConstants {
  double traverse = 1;   ///< C_I: visiting an inner node. Range >= 0.
  double intersect = 1;  ///< Testing one unit of weight. Range > 0.
  double empty_bonus =
      0.85;  ///< Factor on the children's cost if one of them is empty. Range (0, 1].

  bool operator==(const SahConstants&) const = default;
};

/// The longest axis of the cell; of equal ones the first.
inline int longest_axis(const geometry::Aabb& cell) {
  const geometry::Vec3f e = cell.hi - cell.lo;
  return e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
}

/// 1 / SA(cell), in half areas as in SplitAreas; 0 for a cell without area.
inline double per_area(const geometry::Aabb& cell) {
  const double whole = half_area(cell);
  return whole > 0 ? 1 / whole : 0;
}

/// Half areas of the children of a cell along one axis: SA_L and SA_R are linear in the position of
/// the plane.
class SplitAreas {
 public:
  SplitAreas(const geometry::Aabb& cell, int axis) : SplitAreas(cell, axis, 0) {
    const double whole = ends_ + slope_ * (hi_ - lo_);
    per_whole_ = whole > 0 ? 1 / whole : 0;
  }
  /// Takes 1 / SA(cell) from callers that know it.
  SplitAreas(const geometry::Aabb& cell, int axis, double per_whole) : per_whole_(per_whole) {
    const auto a = static_cast<std::size_t>(axis);
    const auto extent = [&](std::size_t i) {
      return static_cast<double>(cell.hi[i]) - static_cast<double>(cell.lo[i]);
    };
    const double u = extent((a + 1) % 3), v = extent((a + 2) % 3);
    lo_ = static_cast<double>(cell.lo[a]);
    hi_ = static_cast<double>(cell.hi[a]);
    ends_ = u * v;
    slope_ = u + v;
  }
  double left(double x) const { return ends_ + slope_ * (x - lo_); }
  double right(double x) const { return ends_ + slope_ * (hi_ - x); }
  double per_whole() const { return per_whole_; }  ///< 1 / SA(cell).

  /// Expected tests in the children of a cut at x, if these weights lie on its sides and a child is
  /// entered as often as its area says; times `empty_bonus` if one side is empty. bound_cost-inl.h
  /// computes this for many cuts at once, in floats.
  double children(double x, double left_weight, double right_weight, double empty_bonus) const {
    const double sum = (left(x) * left_weight + right(x) * right_weight) * per_whole_;
    const bool one_empty = (left_weight == 0) | (right_weight == 0);  // a branch would mispredict
    return sum * (one_empty ? empty_bonus : 1.0);
  }
  double ends() const { return ends_; }
  double slope() const { return slope_; }

 private:
  double lo_, hi_, ends_, slope_, per_whole_;
};

/// Cost of a split at x with these weights on the sides.
inline double split_cost(const SahConstants& c, const SplitAreas& areas, double x, double left,
                         double right) {
  return c.traverse + c.intersect * areas.children(x, left, right, c.empty_bonus);
}

/// The cheapest split so far. Earlier candidates win ties, so the order of candidates is part of
/// the method.
struct BestSplit {
  kdtree::Plane plane;
  double cost = 0;
  bool found = false;

  void offer(const kdtree::Plane& candidate, double candidate_cost) {
    if (found && !(candidate_cost < cost)) return;
    plane = candidate;
    cost = candidate_cost;
    found = true;
  }
};

}  // namespace sightline::accel::split
