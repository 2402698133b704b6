// How many references the cuts of a subtree may add, and how its children share them. Without it
// the subtree that grows first spends what memory there is.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "accel/kdtree/reference.h"

namespace sightline::accel::grow {

/// Whether a cut that leaves `straddlers` references on both sides is within the cell's budget.
inline bool within_budget(const kdtree::CellPath& path, std::size_t straddlers) {
  return static_cast<double>(straddlers) <= path.references_left;
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
  if (useless && !std::isinf(path.references_left))
    capped.references_left = std::min(path.references_left, kMore * references);
  return capped;
}

/// Measures a child's share of its parent's budget: how often a ray enters the cell, times how many
/// tests it would make there.
inline double demand(const geometry::Aabb& cell, double references) {
  return half_area(cell) * references;
}

/// One of the cells that a division makes.
struct ChildCell {
  geometry::Aabb box;
  double references;
  kdtree::CellPath* path;  ///< Its budget and its duplication are written here.
};

/// Shares the budget of a cell of `before` references out to its children, by demand, less what the
/// division added. No effect on a path without a budget. At least one child.
inline void share_budget(const kdtree::CellPath& parent, double before,
                         std::span<const ChildCell> children) {
  if (std::isinf(parent.references_left)) return;
  double after = 0, demands = 0;
  for (const ChildCell& child : children) {
    after += child.references;
    demands += demand(child.box, child.references);
  }
  const double references_left =
      std::max(0.0, parent.references_left - std::max(0.0, after - before));
  const double duplication = parent.duplication * std::max(1.0, after / before);
  double rest = references_left;
  for (const ChildCell& child : children.first(children.size() - 1)) {
    const double share = demands > 0 ? demand(child.box, child.references) / demands
                                     : 1 / static_cast<double>(children.size());
    child.path->references_left = references_left * share;
    child.path->duplication = duplication;
    rest -= child.path->references_left;
  }
  children.back().path->references_left = std::max(0.0, rest);
  children.back().path->duplication = duplication;
}

/// The paths of both children of a cut, whose lists have `left` and `right` references.
struct HalvedPath {
  kdtree::CellPath left, right;
};
inline HalvedPath halve_path(const kdtree::CellPath& path, const kdtree::Split& cut,
                             const geometry::HalvedCell& halves, double before, double left,
                             double right) {
  HalvedPath below{path.below(cut), path.below(cut)};
  const std::array<ChildCell, 2> children{
      {{halves.left, left, &below.left}, {halves.right, right, &below.right}}};
  share_budget(path, before, children);
  return below;
}

}  // namespace sightline::accel::grow
