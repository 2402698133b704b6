// The distance rule: how far a point is from a face, and where the face is nearest. A pure function
// of the two: it does not depend on the cell, builder, thread or SIMD target.
// docs/distance_rule.md has the proof.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "accel/geometry/vec3.h"

namespace sightline::accel::geometry {

struct Feature;
struct SeenFace;

/// Returns the distance of p from the face with corners M a, M b, M c, where M is
/// `world_from_local`: 3 rows of 4, the last column is the translation. All numbers are used as
/// exact real numbers, and the distance is rounded once, to the nearest double, ties to even.
///
/// Coordinates of p are at most kLargestRay, and count as zero below kSmallestRay, as a ray's
/// origin; vertices and matrix are finite, of any size. A face without area is the segment or the
/// point that it is. The distance is 0 exactly if p is on the face (or if it rounds to 0), and
/// infinite if it rounds beyond the largest double.
double distance(const Vec3d& p, const std::array<double, 12>& world_from_local, const Vec3f& a,
                const Vec3f& b, const Vec3f& c);

/// What is known of the face that is nearest to a point.
struct NearestKnown {
  double distance = std::numeric_limits<double>::infinity();  ///< It is at most so far,
  Vec3d way;  ///< in about this direction, of any length; zero: not known.
};

/// Asks for distances of several faces from one point, under one matrix. Those around the corner or
/// the edge that was nearest before are as far, and cost less.
class DistancesFrom {
 public:
  /// `world_from_local` must outlive it.
  DistancesFrom(const Vec3d& p, const std::array<double, 12>& world_from_local);

  /// What distance() returns.
  double to(const Vec3f& a, const Vec3f& b, const Vec3f& c);

  /// Returns false if to() would certainly return more than for the face that `known` is about.
  /// Otherwise sets `known` to the nearest corner of this face, if that is nearer.
  bool approach(const Vec3f& a, const Vec3f& b, const Vec3f& c, NearestKnown& known) const;

 private:
  using Vertices = std::array<Vec3f, 3>;

  bool has_corner(const Vertices& vertices, std::size_t i) const;
  bool has_edge(const Vertices& vertices, std::size_t i) const;
  bool has_nearest(const Vertices& vertices) const;
  bool is_nearest(const Vertices& vertices, const Feature& feature) const;

  const Vec3d p_;
  const std::array<double, 12>& matrix_;
  const bool is_plain_;     // The matrix is the identity.
  const bool is_in_range_;  // The matrix is.
  /// The corners of the part that was nearest to the point: none, one or two.
  std::size_t corners_ = 0;
  std::array<Vec3f, 2> nearest_;
  double distance_ = 0;
};

struct ClosestPoint {
  Vec3d position;
  double u = 0, v = 0;  ///< Weights of vertices 1 and 2: both >= 0, sum <= 1.
};

/// Returns the point of the face that is nearest to p, for the same arguments. It is unique.
///
/// Each coordinate is off by at most 2 ulp of the largest coordinate of p and of the face; a corner
/// is rounded once. Weights: a corner has exactly 0 or 1, u is 0 on edge 0-2, v is 0 on edge 0-1,
/// and v = 1 - u on edge 1-2.
ClosestPoint closest_point(const Vec3d& p, const std::array<double, 12>& world_from_local,
                           const Vec3f& a, const Vec3f& b, const Vec3f& c);

}  // namespace sightline::accel::geometry
