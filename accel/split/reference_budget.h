// How many references the cuts of a subtree may add, and how its children share them. Without it
// the subtree that grows first spends what memory there is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "accel/kdtree/reference.h"

namespace sightline::accel::split {

/// By how much more than of a surface cuts have multiplied a cell's references. Of n triangles of a
/// surface about sqrt(n) lie across the border of what holds them, so that there a path's
/// duplication is 1 and a few sqrt(1 / n), and this is a few at most.
inline double duplication_excess(const kdtree::CellPath& path, double references) {
  return (path.duplication - 1) * (path.duplication - 1) * references;
}

/// Whether a cell's triangles are long, by its excess. Costs little if it is wrong.
inline bool is_over_duplicated(const kdtree::CellPath& path, std::size_t references) {
  constexpr double kLeastDuplication = 2, kMost = 256;
  return path.duplication >= kLeastDuplication &&
         duplication_excess(path, static_cast<double>(references)) >= kMost;
}

/// Whether they are long for sure: worth what is spent on few cells of other meshes.
inline bool is_long(const kdtree::CellPath& path, double references) {
  constexpr double kMost = 1024;
  return duplication_excess(path, references) >= kMost;
}

/// Whether a cell is worth a search for a cut. A swollen one is not, if it is small or can afford
/// next to none: to look would cost more than any ray gains.
inline bool is_worth_cutting(const kdtree::CellPath& path, std::size_t references) {
  constexpr std::size_t kSmall = 8;
  constexpr double kLeastShareLeft = 0.125;  // a reference
  if (!is_over_duplicated(path, references)) return true;
  return references > kSmall &&
         path.references_left >= kLeastShareLeft * static_cast<double>(references);
}

/// Whether a cut that leaves so many of a cell's references on both sides may be made. Of long
/// triangles, once they have become many, the last cut of a path may take twice what is left: as
/// many others find less than they need, and leave it.
inline bool within_budget(const kdtree::CellPath& path, std::size_t references,
                          std::size_t straddlers) {
  constexpr double kMany = 4;
  const bool twice = path.duplication >= kMany && is_long(path, static_cast<double>(references));
  return static_cast<double>(straddlers) <= (twice ? 2 : 1) * path.references_left;
}

/// What a cell may still add after its list of `before` references became lists of `after`, all
/// together.
inline double left_over(const kdtree::CellPath& path, double before, double after) {
  return std::max(0.0, path.references_left - std::max(0.0, after - before));
}

/// Whether a cut of a list of `before` long triangles, or several, that left `after` of them all
/// together, parted them little.
inline bool separates_poorly(const kdtree::CellPath& path, double before, double after) {
  constexpr double kList = 32, kLittle = 1.05;
  return before > kList && after >= kLittle * before && is_long(path, before);
}

/// How often a cell's references will be looked at: what its share is measured by. Where cuts part
/// little, a long list needs more than its length says: short ones are soon done, and leave what
/// they have.
inline double demand(const geometry::Aabb& cell, double references, bool separated_poorly) {
  return half_area(cell) * references * (separated_poorly ? std::sqrt(references) : 1);
}

/// The paths of both halves, their lists being so long.
struct HalvedPath {
  kdtree::CellPath left, right;
};
inline HalvedPath halve_path(const kdtree::CellPath& path, const kdtree::Split& cut,
                             const geometry::HalvedCell& halves, double before, double left,
                             double right) {
  HalvedPath below{path.below(cut), path.below(cut)};
  if (std::isinf(path.references_left)) return below;
  const double references_left = left_over(path, before, left + right);
  const bool little = separates_poorly(path, before, left + right);
  const double to_left = demand(halves.left, left, little);
  const double to_right = demand(halves.right, right, little);
  const double share = to_left + to_right > 0 ? to_left / (to_left + to_right) : 0.5;
  below.left.references_left = references_left * share;
  below.right.references_left = references_left - below.left.references_left;
  below.left.duplication = below.right.duplication =
      path.duplication * std::max(1.0, (left + right) / before);
  return below;
}

}  // namespace sightline::accel::split
