// The hit rule of docs/hit_rule.md by its definition, in exact arithmetic: the reference for
// `intersect`. Shares no code with it, and none of the identities that it uses.
#pragma once

#include <gmpxx.h>

#include "accel/geometry/vec3.h"
#include "tests/support/rational.h"

namespace sightline::tests {

/// The line o + t d. All numbers are used as given; d is not zero.
class RationalRay {
 public:
  RationalRay(const accel::geometry::Vec3d& origin, const accel::geometry::Vec3d& direction);

  /// The sign of det[d, p - o, q - o]: the side of the edge from p to q on which the line passes.
  int side(const DyadicVec& p, const DyadicVec& q) const;
  /// The same for the line through o + (e, e^2, e^3), for all sufficiently small e > 0.
  /// 0 if the determinant is zero for all e.
  int perturbed_side(const DyadicVec& p, const DyadicVec& q) const;
  /// The sign of N . d with N = (b - a) x (c - a): 0 for a triangle seen edge-on.
  int facing(const DyadicVec& a, const DyadicVec& b, const DyadicVec& c) const;

  const DyadicVec& origin() const { return origin_; }
  const DyadicVec& direction() const { return direction_; }

 private:
  DyadicVec origin_, direction_;
  DyadicVec moment_;  // o x d
};

struct RationalHit {
  bool hit = false;
  int zeros = 0;  ///< The number of determinants that are zero before the perturbation.
};
RationalHit judge(const RationalRay& ray, const DyadicVec& a, const DyadicVec& b,
                  const DyadicVec& c);

/// The point where the line meets the plane of a triangle that is not edge-on. Errors are in units
/// of the largest |v - o| of the three vertices, in the maximum norm.
class RationalMeeting {
 public:
  RationalMeeting(const RationalRay& ray, const DyadicVec& a, const DyadicVec& b,
                  const DyadicVec& c);

  mpq_class t() const { return numerator_.rational() / denominator_.rational(); }
  /// The error of a value of t.
  double t_error(double t) const;
  /// The error of the point with these weights of b and c, in the maximum norm.
  double point_error(double u, double v) const;

 private:
  DyadicVec direction_, from_a_, to_b_, to_c_;  // a - o, b - a, c - a
  Dyadic numerator_, denominator_;
  Dyadic unit_;  // The largest |v - o| times the denominator
};

}  // namespace sightline::tests
