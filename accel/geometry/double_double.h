// Numbers of about 106 bits: unevaluated sums of two doubles. Source: Joldes, Muller, Popescu 2017,
// "Tight and Rigorous Error Bounds for Basic Building Blocks of Double-Word Arithmetic".
//
// Bounds hold if no product overflows or falls below 2^-960, so that its error is a normal number.
#pragma once

#include <cmath>

#include "accel/geometry/vec3.h"

namespace sightline::accel::geometry {

/// high + low, where high is the sum rounded to double.
struct DoubleDouble {
  double high = 0, low = 0;
};

/// a + b, exactly.
inline DoubleDouble two_sum(double a, double b) {
  const double sum = a + b, bb = sum - a;
  return {sum, (a - (sum - bb)) + (b - bb)};
}

/// a + b, exactly, if a is 0 or |a| >= |b|.
inline DoubleDouble quick_two_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

/// x as a sum of two numbers of at most 26 bits (Veltkamp).
inline DoubleDouble halves(double x) {
  const double scaled = 0x1.000002p+27 * x;
  const double high = scaled - (scaled - x);
  return {high, x - high};
}

/// a * b, exactly (Dekker). Without a fused operation, which not all processors have.
inline DoubleDouble two_product(double a, double b) {
  const DoubleDouble x = halves(a), y = halves(b);
  const double product = a * b;
  const double error =
      ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low;
  return {product, error};
}

inline DoubleDouble operator-(const DoubleDouble& a) { return {-a.high, -a.low}; }

/// The relative error is below 4 * 2^-106, also where the sum cancels.
inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble high = two_sum(a.high, b.high), low = two_sum(a.low, b.low);
  const DoubleDouble sum = quick_two_sum(high.high, high.low + low.high);
  return quick_two_sum(sum.high, low.low + sum.low);
}
inline DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + -b; }

/// The relative error is below 8 * 2^-106.
inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble product = two_product(a.high, b.high);
  return quick_two_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

/// The relative error is below 32 * 2^-106.
inline DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
  const double quotient = a.high / b.high;
  const DoubleDouble rest = a - b * DoubleDouble{quotient};
  return quick_two_sum(quotient, rest.high / b.high);
}

/// The root of n / d, for positive n and d. The relative error is below 18 * 2^-106.
inline DoubleDouble root_of_quotient(const DoubleDouble& n, const DoubleDouble& d) {
  const double root = std::sqrt(n.high / d.high);
  const DoubleDouble rest = n - two_product(root, root) * d;
  return quick_two_sum(root, rest.high / (2 * root * d.high));
}

using Vec3dd = Vec3<DoubleDouble>;

inline Vec3d high(const Vec3dd& v) { return {v.x.high, v.y.high, v.z.high}; }
inline const Vec3d& high(const Vec3d& v) { return v; }
inline double high(const DoubleDouble& x) { return x.high; }
inline double high(double x) { return x; }

}  // namespace sightline::accel::geometry
