// How many references the cuts of a subtree may add, and how its children share them. Without it
// the subtree that grows first spends what memory there is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "accel/build/box_ref.h"

namespace sightline::accel {

/// Whether a cut that leaves so many references on both sides may be made.
inline bool affords(const CellPath& path, std::size_t straddlers) {
  return static_cast<double>(straddlers) <= path.spare;
}

/// What a cell may still add after its list of `before` references became lists of `after`, all
/// together.
inline double left_over(const CellPath& path, double before, double after) {
  return std::max(0.0, path.spare - std::max(0.0, after - before));
}

/// How often a cell's references will be looked at: what its share is measured by.
inline double demand(const Aabb& cell, double references) { return half_area(cell) * references; }

/// The paths of both halves, their lists being so long.
struct HalvedPath {
  CellPath left, right;
};
inline HalvedPath halve_path(const CellPath& path, const Cut& cut, const HalvedCell& halves,
                             double before, double left, double right) {
  HalvedPath below{path.below(cut), path.below(cut)};
  if (std::isinf(path.spare)) return below;
  const double spare = left_over(path, before, left + right);
  const double to_left = demand(halves.left, left), to_right = demand(halves.right, right);
  const double share = to_left + to_right > 0 ? to_left / (to_left + to_right) : 0.5;
  below.left.spare = spare * share;
  below.right.spare = spare - below.left.spare;
  return below;
}

}  // namespace sightline::accel
