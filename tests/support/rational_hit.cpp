// The hit rule by its definition, in exact arithmetic.
#include "tests/support/rational_hit.h"

#include <algorithm>
#include <array>

namespace sightline::tests {
namespace {

/// A polynomial in e. The determinant of the moved ray has degree five: e^2 of y times e^3 of z.
using Polynomial = std::array<Dyadic, 6>;

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial result;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].sign() == 0) continue;
    for (std::size_t j = 0; i + j < b.size(); ++j) result[i + j] = result[i + j] + a[i] * b[j];
  }
  return result;
}

/// p - o(e), one polynomial a component.
std::array<Polynomial, 3> from_moved_origin(const DyadicVec& p, const DyadicVec& origin) {
  std::array<Polynomial, 3> result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result[axis][0] = p[axis] - origin[axis];
    result[axis][axis + 1] = Dyadic(-1.0);
  }
  return result;
}

}  // namespace

RationalRay::RationalRay(const accel::geometry::Vec3d& origin,
                         const accel::geometry::Vec3d& direction)
    : origin_(exactly(origin)),
      direction_(exactly(direction)),
      moment_(cross(origin_, direction_)) {}

// By the Pluecker coordinates of the two lines.
int RationalRay::side(const DyadicVec& p, const DyadicVec& q) const {
  return (dot(direction_, cross(p, q)) + dot(moment_, q - p)).sign();
}

int RationalRay::perturbed_side(const DyadicVec& p, const DyadicVec& q) const {
  const auto from_p = from_moved_origin(p, origin_), from_q = from_moved_origin(q, origin_);
  Polynomial determinant;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const Polynomial plus = product(from_p[j], from_q[k]), minus = product(from_p[k], from_q[j]);
    for (std::size_t n = 0; n < determinant.size(); ++n) {
      determinant[n] = determinant[n] + direction_[i] * (plus[n] - minus[n]);
    }
  }
  for (const Dyadic& coefficient : determinant) {
    if (coefficient.sign() != 0) return coefficient.sign();
  }
  return 0;
}

int RationalRay::facing(const DyadicVec& a, const DyadicVec& b, const DyadicVec& c) const {
  return dot(cross(b - a, c - a), direction_).sign();
}

RationalHit judge(const RationalRay& ray, const DyadicVec& a, const DyadicVec& b,
                  const DyadicVec& c) {
  RationalHit result;
  const auto decide = [&](const DyadicVec& p, const DyadicVec& q) {
    const int side = ray.side(p, q);
    if (side != 0) return side;
    ++result.zeros;
    return ray.perturbed_side(p, q);
  };
  const int ab = decide(a, b), bc = decide(b, c), ca = decide(c, a);
  result.hit = ab != 0 && ab == bc && bc == ca;
  return result;
}

RationalMeeting::RationalMeeting(const RationalRay& ray, const DyadicVec& a, const DyadicVec& b,
                                 const DyadicVec& c)
    : direction_(ray.direction()), from_a_(a - ray.origin()), to_b_(b - a), to_c_(c - a) {
  const DyadicVec normal = cross(to_b_, to_c_);
  numerator_ = dot(normal, from_a_);
  denominator_ = dot(normal, direction_);
  Dyadic reach;
  for (const DyadicVec& from_origin : {from_a_, b - ray.origin(), c - ray.origin()}) {
    for (const Dyadic& component : from_origin) {
      const Dyadic size = component.magnitude();
      if ((size - reach).sign() > 0) reach = size;
    }
  }
  unit_ = (reach * denominator_).magnitude();
}

double RationalMeeting::t_error(double t) const {
  return Dyadic::ratio((Dyadic(t) * denominator_ - numerator_).magnitude(), unit_);
}

double RationalMeeting::point_error(double u, double v) const {
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Dyadic named = from_a_[axis] + Dyadic(u) * to_b_[axis] + Dyadic(v) * to_c_[axis];
    const Dyadic off = named * denominator_ - numerator_ * direction_[axis];
    largest = std::max(largest, Dyadic::ratio(off.magnitude(), unit_));
  }
  return largest;
}

}  // namespace sightline::tests
