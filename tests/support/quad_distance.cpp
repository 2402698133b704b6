// The distance of a point from a face in 113 bits.
#include "tests/support/quad_distance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/distance_bounds.h"
#include "tests/support/rational_distance.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

// The largest sum of magnitudes of the terms of a coordinate of M v - p.
double largest_terms(const scenegraph::model::Affine& m, const Vec3d& p, const Vec3f& v) {
  double largest = 0;
  const Vec3d local(v);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* row = &m.m[4 * axis];
    largest =
        std::max(largest, std::abs(row[0] * local.x) + std::abs(row[1] * local.y) +
                              std::abs(row[2] * local.z) + std::abs(row[3]) + std::abs(p[axis]));
  }
  return largest;
}

}  // namespace

std::optional<double> quad_distance(const Vec3d& p,
                                    const scenegraph::model::Affine& world_from_local,
                                    const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3d from = without_tiny(p);
  std::array<QuadVec, 3> corner;
  double terms = 0;
  Quad reach = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3f& v = i == 0 ? a : i == 1 ? b : c;
    terms = std::max(terms, largest_terms(world_from_local, from, v));
    corner[i] = transform(world_from_local, v) - widen(from);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      reach = std::max(reach, absolute(corner[i][axis]));
    }
  }
  if (!(terms > 0x1p-400 && terms < 0x1p+1000)) return std::nullopt;
  // A product of a double and a float is exact; four sums round, by a unit of `terms` each and
  // axis. A corner is not farther than twice its largest coordinate.
  constexpr Quad kUnit = Precision<Quad>::kUnit;
  const Quad slack = 64 * kUnit * reach + 16 * kUnit * Quad{terms};
  const auto bounds = distance_bounds(corner, slack);
  const auto low = static_cast<double>(bounds.lower), high = static_cast<double>(bounds.upper);
  if (!(bounds.lower > 0 && low == high)) return std::nullopt;
  return low;
}

}  // namespace sightline::tests
