// The distance of a point from a face in exact arithmetic, rounded by an integer root.
#include "tests/support/rational_distance.h"

#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tests/support/rational.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3f;

/// numerator / denominator; the denominator is positive.
struct Quotient {
  Dyadic numerator, denominator;
};

bool is_less(const Quotient& a, const Quotient& b) {
  return (a.numerator * b.denominator - b.numerator * a.denominator).sign() < 0;
}

DyadicVec times(const DyadicVec& v, const Dyadic& s) { return {v[0] * s, v[1] * s, v[2] * s}; }

// M v - p.
DyadicVec corner_from(const accel::geometry::Vec3d& p, const std::array<double, 12>& m,
                      const Vec3f& v) {
  const DyadicVec local = exactly(v);
  DyadicVec result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t row = 4 * axis;
    const DyadicVec linear{Dyadic(m[row]), Dyadic(m[row + 1]), Dyadic(m[row + 2])};
    result[axis] = dot(linear, local) + Dyadic(m[row + 3]) - Dyadic(p[axis]);
  }
  return result;
}

// The squared distance of the origin from the segment between a and b, ends included.
Quotient square_to_segment(const DyadicVec& a, const DyadicVec& b) {
  const Dyadic one(1.0);
  const DyadicVec edge = b - a;
  const Dyadic along = -dot(a, edge), whole = dot(edge, edge);  // The foot is a + edge along/whole
  if (along.sign() <= 0) return {dot(a, a), one};
  if ((along - whole).sign() >= 0) return {dot(b, b), one};
  const DyadicVec start = times(a, whole), step = times(edge, along);
  const DyadicVec foot{start[0] + step[0], start[1] + step[1], start[2] + step[2]};
  return {dot(foot, foot), whole * whole};
}

// The squared distance of the origin from the plane, if its foot is strictly inside the triangle.
std::optional<Quotient> square_to_inside(const std::array<DyadicVec, 3>& corner) {
  const DyadicVec normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const Dyadic square = dot(normal, normal);
  if (square.sign() == 0) return std::nullopt;
  // All points are multiplied by `square`, so that the foot needs no division.
  const DyadicVec foot = times(normal, dot(corner[0], normal));
  for (std::size_t i = 0; i < 3; ++i) {
    const DyadicVec edge = corner[(i + 1) % 3] - corner[i];
    const DyadicVec to_foot = foot - times(corner[i], square);
    if (dot(normal, cross(edge, to_foot)).sign() <= 0) return std::nullopt;
  }
  return Quotient{dot(foot, foot), square * square};
}

// The root of a number that is not negative, rounded to nearest, ties to even.
double rounded_root(const mpq_class& x) {
  if (sgn(x) == 0) return 0;
  // root = floor(sqrt(x) 2^k), where k leaves at least 64 bits and reaches below all doubles.
  const auto bits = [](const mpz_class& n) {
    return static_cast<long>(mpz_sizeinbase(n.get_mpz_t(), 2));
  };
  const long missing = 130 + bits(x.get_den()) - bits(x.get_num());
  const long k = std::max(1200L, missing / 2 + 1);
  const mpz_class scaled = x.get_num() << static_cast<mp_bitcnt_t>(2 * k);
  mpz_class whole, rest, root, root_rest;
  mpz_fdiv_qr(whole.get_mpz_t(), rest.get_mpz_t(), scaled.get_mpz_t(), x.get_den_mpz_t());
  mpz_sqrtrem(root.get_mpz_t(), root_rest.get_mpz_t(), whole.get_mpz_t());
  const bool is_exact = sgn(rest) == 0 && sgn(root_rest) == 0;

  // The result is a multiple of 2^last: 53 bits, or fewer where doubles are denormal.
  const long last = std::max(bits(root) - k - 53, -1074L);
  const auto dropped = static_cast<mp_bitcnt_t>(last + k);
  mpz_class mantissa = root >> dropped;
  const mpz_class below = root - (mantissa << dropped), half = mpz_class(1) << (dropped - 1);
  const bool is_odd = mpz_odd_p(mantissa.get_mpz_t()) != 0;
  if (below > half || (below == half && (!is_exact || is_odd))) ++mantissa;
  return std::ldexp(mantissa.get_d(), static_cast<int>(last));
}

}  // namespace

accel::geometry::Vec3d without_tiny(const accel::geometry::Vec3d& p) {
  const auto kept = [](double x) { return std::abs(x) < 0x1p-250 ? 0.0 : x; };
  return {kept(p.x), kept(p.y), kept(p.z)};
}

double rational_distance(const accel::geometry::Vec3d& p,
                         const std::array<double, 12>& world_from_local, const Vec3f& a,
                         const Vec3f& b, const Vec3f& c) {
  const accel::geometry::Vec3d from = without_tiny(p);
  const std::array<DyadicVec, 3> corner{corner_from(from, world_from_local, a),
                                        corner_from(from, world_from_local, b),
                                        corner_from(from, world_from_local, c)};
  Quotient least = square_to_segment(corner[0], corner[1]);
  const auto include = [&](const Quotient& square) {
    if (is_less(square, least)) least = square;
  };
  include(square_to_segment(corner[1], corner[2]));
  include(square_to_segment(corner[2], corner[0]));
  if (const auto inside = square_to_inside(corner)) include(*inside);
  return rounded_root(least.numerator.rational() / least.denominator.rational());
}

}  // namespace sightline::tests
