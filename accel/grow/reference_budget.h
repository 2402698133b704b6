// How many references the cuts of a subtree may add, and how its children share them; and how many
// may wait in lists. Without it the subtree that grows first spends what memory there is.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "accel/kdtree/reference.h"

namespace sightline::accel::grow {

/// The lists that wait on one path of a tree hold at most this many references for each one of the
/// root: those of the siblings of all cells of the path, and both children's of the last cut. Lists
/// that cuts separate well hold two.
inline constexpr double kListCapacity = 3.5;

/// What the root of a tree over `references` inherits, if its leaves may hold `budget` of them for
/// each one; 0: any number.
inline kdtree::CellPath root_path(double budget, std::size_t references) {
  if (budget == 0) return {};
  const auto n = static_cast<double>(references);
  return {.references_left = (budget - 1) * n, .list_capacity = kListCapacity * n};
}

/// Whether a cut of `references`, which leaves `straddlers` of them on both sides, is within the
/// cell's budget, and its lists within the room for lists.
inline bool within_budget(const kdtree::CellPath& path, double references, double straddlers) {
  return straddlers <= path.references_left && references + straddlers <= path.list_capacity;
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
  double references;       ///< By weight, if some can be opened.
  double listed;           ///< In its list.
  kdtree::CellPath* path;  ///< Its budget, its room and its duplication are written here.
};

/// Shares the budget of a cell of `before` references out to its children, by demand, less what the
/// division added. The room of a child is what the lists of the others leave. No effect on a path
/// without a budget. At least one child.
inline void share_budget(const kdtree::CellPath& parent, double before,
                         std::span<const ChildCell> children) {
  if (std::isinf(parent.references_left)) return;
  double after = 0, demands = 0, listed = 0;
  for (const ChildCell& child : children) {
    after += child.references;
    listed += child.listed;
    demands += demand(child.box, child.references);
  }
  const double references_left =
      std::max(0.0, parent.references_left - std::max(0.0, after - before));
  const double duplication = parent.duplication * std::max(1.0, after / before);
  for (const ChildCell& child : children)
    child.path->list_capacity = parent.list_capacity - (listed - child.listed);
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

/// References on both sides of a cut.
struct SideCounts {
  double left = 0, right = 0;
};

/// The paths of both children of a cut, which have `after` references; `listed` are in their lists.
struct HalvedPath {
  kdtree::CellPath left, right;
};
inline HalvedPath halve_path(const kdtree::CellPath& path, const kdtree::Split& cut,
                             const geometry::HalvedCell& halves, double before,
                             const SideCounts& after, const SideCounts& listed) {
  HalvedPath below{path.below(cut), path.below(cut)};
  const std::array<ChildCell, 2> children{
      {{halves.left, after.left, listed.left, &below.left},
       {halves.right, after.right, listed.right, &below.right}}};
  share_budget(path, before, children);
  return below;
}

}  // namespace sightline::accel::grow
