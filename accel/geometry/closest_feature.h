// Which corner or edge of a face, or its inside, is nearest to the point from which its corners are
// seen. docs/distance_rule.md has the proof.
#pragma once

#include <array>
#include <cstddef>

#include "accel/geometry/closest.h"

namespace sightline::accel::geometry {

/// Corners are numbered 0 to 2; edge i goes from corner i to the corner after it.
inline std::size_t corner_after(std::size_t i) { return i == 2 ? 0 : i + 1; }
inline std::size_t corner_before(std::size_t i) { return i == 0 ? 2 : i - 1; }

/// The sign of a computed number; 0 also where its error may be larger than it is.
struct Sign {
  int value = 0;
  bool certain = true;
};

enum class Part { kCorner, kEdge, kInside, kUnknown };

struct Feature {
  Part part = Part::kUnknown;
  std::size_t index = 0;  ///< Of the corner or edge
  bool certain = false;   ///< That no other feature is nearer
};

/// `signs` gives, with r for corners seen from the point, e for edges and N for the normal:
///
///   along(i, j)     the sign of r_i . e_j
///   side(i)         the sign of (e_i x r_i) . N, which is negative if the point is seen inside
///   edge
///                   i, looking along N
///   has_length(i)   whether e_i is not 0
///
/// Of two features whose signs are not certain the smaller is taken: its distance is nearly right
/// for faces of any shape.
template <class Signs>
Feature nearest_feature(const Signs& signs) {
  std::array<Sign, 3> begin, end, side;
  for (std::size_t i = 0; i < 3; ++i) {
    begin[i] = signs.along(i, i);
    end[i] = signs.along(corner_after(i), i);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Sign& before = end[corner_before(i)];
    if (begin[i].value >= 0 && before.value <= 0)
      return {Part::kCorner, i, begin[i].certain && before.certain};
  }
  for (std::size_t i = 0; i < 3; ++i) side[i] = signs.side(i);
  for (std::size_t i = 0; i < 3; ++i) {
    if (signs.has_length(i) && begin[i].value <= 0 && end[i].value >= 0 && side[i].value >= 0)
      return {Part::kEdge, i, begin[i].certain && end[i].certain && side[i].certain};
  }
  for (const Sign& s : side) {
    if (s.value >= 0) return {};
  }
  return {Part::kInside, 0, true};
}

/// The answers of closest_point() for corner i, for a fraction t in [0, 1] of edge i, and for
/// computed weights inside.
inline ClosestPoint on_corner(std::size_t i, const Vec3d& position) {
  return {position, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
}
inline ClosestPoint on_edge(std::size_t i, double t, const Vec3d& position) {
  if (i == 0) return {position, t, 0};
  if (i == 2) return {position, 0, 1 - t};
  return {position, 1 - t, 1 - (1 - t)};
}
inline ClosestPoint inside(double u, double v, const Vec3d& position) {
  return {position, u, u + v > 1 ? 1 - u : v};
}

}  // namespace sightline::accel::geometry
