// Exact numbers: integers times a power of two, of any length. Every float and double is one.
#pragma once

#include <gmpxx.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "accel/geometry/vec3.h"

namespace sightline::tests {

/// mantissa * 2^exponent. Sums and products are exact; quotients are rationals (mpq_class).
class Dyadic {
 public:
  Dyadic() = default;
  /// x must be finite.
  explicit Dyadic(double x) {
    if (x == 0) return;
    const auto whole = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent_), 53));
    const int zeros =
        std::countr_zero(static_cast<std::uint64_t>(whole));  // Short numbers are fast
    exponent_ += zeros - 53;
    mantissa_ = static_cast<long>(whole / (std::int64_t{1} << zeros));
  }

  int sign() const { return sgn(mantissa_); }

  Dyadic operator-() const { return {-mantissa_, exponent_}; }
  Dyadic operator*(const Dyadic& other) const {
    return {mantissa_ * other.mantissa_, exponent_ + other.exponent_};
  }
  Dyadic operator+(const Dyadic& other) const {
    if (sign() == 0) return other;
    if (other.sign() == 0) return *this;
    const int shift = exponent_ - other.exponent_;
    if (shift > 0) return {shifted(mantissa_, shift) + other.mantissa_, other.exponent_};
    if (shift < 0) return {mantissa_ + shifted(other.mantissa_, -shift), exponent_};
    return {mantissa_ + other.mantissa_, exponent_};
  }
  Dyadic operator-(const Dyadic& other) const {
    if (sign() == 0) return -other;
    if (other.sign() == 0) return *this;
    const int shift = exponent_ - other.exponent_;
    if (shift > 0) return {shifted(mantissa_, shift) - other.mantissa_, other.exponent_};
    if (shift < 0) return {mantissa_ - shifted(other.mantissa_, -shift), exponent_};
    return {mantissa_ - other.mantissa_, exponent_};
  }

  Dyadic magnitude() const { return {abs(mantissa_), exponent_}; }

  mpq_class rational() const {
    return exponent_ >= 0 ? mpq_class(shifted(mantissa_, exponent_))
                          : mpq_class(mantissa_) / mpq_class(shifted(1, -exponent_));
  }

  /// a / b to about 50 bits; b is not zero.
  static double ratio(const Dyadic& a, const Dyadic& b) {
    signed long ea = 0, eb = 0;
    const double ma = mpz_get_d_2exp(&ea, a.mantissa_.get_mpz_t());
    const double mb = mpz_get_d_2exp(&eb, b.mantissa_.get_mpz_t());
    return std::ldexp(ma / mb, static_cast<int>(ea - eb) + a.exponent_ - b.exponent_);
  }

 private:
  Dyadic(mpz_class mantissa, int exponent) : mantissa_(std::move(mantissa)), exponent_(exponent) {}

  static mpz_class shifted(const mpz_class& x, int bits) {
    return x << static_cast<mp_bitcnt_t>(bits);
  }

  mpz_class mantissa_;  // If zero, the exponent is meaningless
  int exponent_ = 0;
};

using DyadicVec = std::array<Dyadic, 3>;

inline DyadicVec exactly(const accel::geometry::Vec3d& v) {
  return {Dyadic(v.x), Dyadic(v.y), Dyadic(v.z)};
}
inline DyadicVec exactly(const accel::geometry::Vec3f& v) {
  return exactly(accel::geometry::Vec3d(v));
}

inline DyadicVec operator-(const DyadicVec& a, const DyadicVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Dyadic dot(const DyadicVec& a, const DyadicVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline DyadicVec cross(const DyadicVec& a, const DyadicVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace sightline::tests
