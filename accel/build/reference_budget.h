// How many references the cuts of a subtree may add, and how its children share them. Without it
// the subtree that grows first spends what memory there is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "accel/build/box_ref.h"

namespace sightline::accel {

/// Whether cuts have multiplied a cell's references far beyond what they do of a surface: its
/// triangles are long. Of n triangles of a surface about sqrt(n) lie across the border of what
/// holds them, so that there a path's swell is 1 and a few sqrt(1 / n).
inline bool is_swollen(const CellPath& path, std::size_t references) {
  constexpr double kLeastSwell = 2, kBorder = 16;
  const double more = path.swell - 1;
  return path.swell >= kLeastSwell &&
         more * more * static_cast<double>(references) >= kBorder * kBorder;
}

/// Whether a cell is worth a search for a cut. A swollen one is not, if it is small or can afford
/// next to none: to look would cost more than any ray gains.
inline bool is_worth_cutting(const CellPath& path, std::size_t references) {
  constexpr std::size_t kSmall = 8;
  constexpr double kLeastSpare = 0.125;  // a reference
  if (!is_swollen(path, references)) return true;
  return references > kSmall && path.spare >= kLeastSpare * static_cast<double>(references);
}

/// Whether a cut that leaves so many references on both sides may be made. The last cut of a path
/// on which they have become many may take twice what is left: as many others find less than they
/// need, and leave it.
inline bool affords(const CellPath& path, std::size_t straddlers) {
  constexpr double kMany = 4;
  return static_cast<double>(straddlers) <= (path.swell >= kMany ? 2 : 1) * path.spare;
}

/// What a cell may still add after its list of `before` references became lists of `after`, all
/// together.
inline double left_over(const CellPath& path, double before, double after) {
  return std::max(0.0, path.spare - std::max(0.0, after - before));
}

/// Whether a cut of a list of `before` references, or several, that left `after` of them all
/// together, parted them little.
inline bool parts_little(double before, double after) {
  constexpr double kLong = 32, kLittle = 1.05;
  return before > kLong && after >= kLittle * before;
}

/// How often a cell's references will be looked at: what its share is measured by. Where cuts part
/// little, a long list needs more than its length says: short ones are soon done, and leave what
/// they have.
inline double demand(const Aabb& cell, double references, bool parted_little) {
  return half_area(cell) * references * (parted_little ? std::sqrt(references) : 1);
}

/// The paths of both halves, their lists being so long.
struct HalvedPath {
  CellPath left, right;
};
inline HalvedPath halve_path(const CellPath& path, const Cut& cut, const HalvedCell& halves,
                             double before, double left, double right) {
  HalvedPath below{path.below(cut), path.below(cut)};
  if (std::isinf(path.spare)) return below;
  const double spare = left_over(path, before, left + right);
  const bool little = parts_little(before, left + right);
  const double to_left = demand(halves.left, left, little);
  const double to_right = demand(halves.right, right, little);
  const double share = to_left + to_right > 0 ? to_left / (to_left + to_right) : 0.5;
  below.left.spare = spare * share;
  below.right.spare = spare - below.left.spare;
  below.left.swell = below.right.swell = path.swell * std::max(1.0, (left + right) / before);
  return below;
}

}  // namespace sightline::accel
