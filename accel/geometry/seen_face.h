// A face as seen from a point, in double-doubles: what the distance rule computes with.
#pragma once

#include <array>
#include <optional>

#include "accel/geometry/double_double.h"

namespace sightline::accel::geometry {

/// Corners minus the point. Edge i goes from corner i to the corner after it.
struct SeenFace {
  std::array<Vec3dd, 3> corner, edge;
  double error = 0;  ///< How far each corner is off at most; edges are those of these corners.
};

struct Feature;

bool is_identity(const std::array<double, 12>& matrix);

/// Whether all coordinates are 0 or between 2^-160 and 2^160.
bool are_in_range(const Vec3d& a, const Vec3d& b, const Vec3d& c);

/// Sets `face`; false if numbers are out of the range where the bounds of the rule hold. All
/// coordinates of corners and edges are then 0 or between 2^-160 and 2^160.
bool see(const Vec3d& p, const std::array<double, 12>& world_from_local,
         const std::array<Vec3f, 3>& vertices, SeenFace& face);

/// Whether products of the matrix neither overflow nor underflow.
bool is_in_range(const std::array<double, 12>& world_from_local);
/// Whether all coordinates of corners and edges are 0 or between 2^-160 and 2^160.
bool is_in_range(const SeenFace& face);

/// Sets the leading doubles of what see() sets, each within `more` / 2^53 of the real number beside
/// its own rounding, and returns `more`. It is 0 if `plain`: the matrix is the identity. Otherwise
/// the matrix is in range. The face need not be.
double see_leading(const Vec3d& p, const std::array<double, 12>& world_from_local, bool plain,
                   const std::array<Vec3f, 3>& vertices, SeenFace& face);
/// After see_leading(), sets all of the corners that a part needs, and of the edges between them:
/// those of corner `index`, of edge `index`, or of all. Returns what see() does, for these.
bool see_part(const Vec3d& p, const std::array<double, 12>& world_from_local,
              const std::array<Vec3f, 3>& vertices, const Feature& part, SeenFace& face);

/// M v rounded once, unless the last bit of a coordinate is in doubt.
std::optional<Vec3d> rounded_corner(const std::array<double, 12>& world_from_local, const Vec3f& v);

}  // namespace sightline::accel::geometry
