// How many references the cuts of a subtree may add, and how its children share them. Without it
// the subtree that grows first spends what memory there is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "accel/kdtree/reference.h"

namespace sightline::accel::split {

/// Whether a cell holds long triangles: cuts above it have multiplied its references far more than
/// those of a surface. Of n triangles of a surface about sqrt(n) cross the border of a cell, so
/// swell - 1 is a few times sqrt(1 / n) there.
inline bool is_swollen(const kdtree::CellPath& path, std::size_t references) {
  constexpr double kLeastSwell = 2, kMost = 256;
  const double growth = path.swell - 1;
  return path.swell >= kLeastSwell && growth * growth * static_cast<double>(references) >= kMost;
}

/// Whether a cut that leaves `straddlers` references on both sides is within the cell's budget.
inline bool affords(const kdtree::CellPath& path, std::size_t straddlers) {
  return static_cast<double>(straddlers) <= path.spare;
}

/// The path of a cell of `before` references, with a smaller budget where its cut, which leaves
/// `left` and `right` references, is useless: one side keeps the whole of a long list, and the
/// other side a large share of it. Triangles that meet in a vertex are cut like this, and the cuts
/// below are as useless, so they may add at most kMore references for each one of the list.
/// No effect on a path without a budget.
inline kdtree::CellPath cap_below_useless_cut(const kdtree::CellPath& path, std::size_t before,
                                              std::size_t left, std::size_t right) {
  constexpr std::size_t kLong = 64;
  constexpr double kShare = 0.4, kMore = 3;
  const auto [fewer, more] = std::minmax(left, right);
  const auto references = static_cast<double>(before);
  const bool useless =
      before > kLong && more >= before && static_cast<double>(fewer) >= kShare * references;
  kdtree::CellPath capped = path;
  if (useless && !std::isinf(path.spare)) capped.spare = std::min(path.spare, kMore * references);
  return capped;
}

/// What a cell may still add after its list of `before` references became lists of `after`, all
/// together.
inline double left_over(const kdtree::CellPath& path, double before, double after) {
  return std::max(0.0, path.spare - std::max(0.0, after - before));
}

/// Measures a child's share of its parent's budget: how often a ray enters the cell, times how many
/// tests it would make there.
inline double demand(const geometry::Aabb& cell, double references) {
  return half_area(cell) * references;
}

/// The paths of both halves, their lists being so long.
struct HalvedPath {
  kdtree::CellPath left, right;
};
inline HalvedPath halve_path(const kdtree::CellPath& path, const kdtree::Cut& cut,
                             const geometry::HalvedCell& halves, double before, double left,
                             double right) {
  HalvedPath below{path.below(cut), path.below(cut)};
  if (std::isinf(path.spare)) return below;
  const double spare = left_over(path, before, left + right);
  const double to_left = demand(halves.left, left);
  const double to_right = demand(halves.right, right);
  const double share = to_left + to_right > 0 ? to_left / (to_left + to_right) : 0.5;
  below.left.spare = spare * share;
  below.right.spare = spare - below.left.spare;
  below.left.swell = below.right.swell = path.swell * std::max(1.0, (left + right) / before);
  return below;
}

}  // namespace sightline::accel::split
