// What tests of the papers' kd-tree builders share: the cost of a cut, and the exact searches.
#pragma once

#include <vector>

#include "accel/geometry/aabb.h"
#include "accel/kdtree/reference.h"
#include "accel/published/kd/exact_builder.h"
#include "accel/split/cost_model.h"

namespace sightline::tests {

inline constexpr accel::published::kd::ExactSearch kExactSearches[] = {
    accel::published::kd::ExactSearch::kNaive, accel::published::kd::ExactSearch::kSort,
    accel::published::kd::ExactSearch::kSweep};

/// The SAH cost of a cell that is cut at a plane, by counting. No box lies in the plane.
inline double counted_cost(const std::vector<accel::kdtree::Reference>& refs,
                           const accel::geometry::Aabb& cell, const accel::kdtree::Plane& plane,
                           const accel::split::SahConstants& constants) {
  const auto axis = static_cast<std::size_t>(plane.axis);
  double left = 0, right = 0;
  for (const accel::kdtree::Reference& ref : refs) {
    left += ref.lo[axis] < plane.position ? ref.weight : 0;
    right += ref.hi[axis] > plane.position ? ref.weight : 0;
  }
  const accel::geometry::HalvedCell halves = halve(cell, plane.axis, plane.position);
  double children =
      (half_area(halves.left) * left + half_area(halves.right) * right) / half_area(cell);
  if (left == 0 || right == 0) children *= constants.empty_bonus;
  return constants.traverse + constants.intersect * children;
}

}  // namespace sightline::tests
