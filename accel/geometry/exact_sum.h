// Exact sums and products of doubles as expansions: lists of non-overlapping doubles, smallest
// first, whose unevaluated sum is the value. Source: Shewchuk 1997, "Adaptive Precision
// Floating-Point Arithmetic and Fast Robust Geometric Predicates", sections 2.3 to 2.7.
//
// Results are exact unless a value overflows or falls below the smallest normal double; LocalRay
// keeps its numbers in a range where neither can happen. The code is rarely used, so it is written
// for clarity, not speed.
#pragma once

#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace sightline::accel::geometry {

/// A sum has at most kCapacity terms. The largest value built here, the numerator of t, has 3 * 64.
class ExactSum {
 public:
  static constexpr std::size_t kCapacity = 320;

  ExactSum() = default;
  explicit ExactSum(double x) { add(x); }

  /// a - b, exactly.
  static ExactSum difference(double a, double b) {
    ExactSum e(a);
    e.add(-b);
    return e;
  }

  /// Adds one double (Shewchuk's GROW-EXPANSION, zeros left out).
  void add(double x) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const double sum = x + terms_[i];
      const double bb = sum - x;
      const double error = (x - (sum - bb)) + (terms_[i] - bb);
      if (error != 0) terms_[kept++] = error;
      x = sum;
    }
    if (x != 0) {
      assert(kept < kCapacity);
      terms_[kept++] = x;
    }
    size_ = kept;
  }

  void add(const ExactSum& other) {
    for (std::size_t i = 0; i < other.size_; ++i) add(other.terms_[i]);
  }
  void subtract(const ExactSum& other) {
    for (std::size_t i = 0; i < other.size_; ++i) add(-other.terms_[i]);
  }

  /// Adds a * b.
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }
  void add_product(const ExactSum& a, const ExactSum& b) {
    for (std::size_t i = 0; i < a.size_; ++i) {
      for (std::size_t j = 0; j < b.size_; ++j) add_product(a.terms_[i], b.terms_[j]);
    }
  }
  /// Adds a * b * c.
  void add_product(const ExactSum& a, const ExactSum& b, const ExactSum& c) {
    ExactSum ab;
    ab.add_product(a, b);
    add_product(ab, c);
  }

  /// The value to within an ulp or two, with its exact sign.
  double estimate() const {
    double sum = 0;
    for (std::size_t i = 0; i < size_; ++i) sum += terms_[i];
    return sum;
  }
  /// -1, 0 or 1: exact, because the last term outweighs all others.
  int sign() const { return size_ == 0 ? 0 : terms_[size_ - 1] > 0 ? 1 : -1; }

 private:
  std::size_t size_ = 0;
  std::array<double, kCapacity> terms_;
};

}  // namespace sightline::accel::geometry
