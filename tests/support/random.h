// SplitMix64: a small random generator with the same numbers on every machine and compiler.
#pragma once

#include <cmath>
#include <cstdint>

#include "accel/geometry/vec3.h"

namespace sightline::tests {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  /// An independent stream for every (seed, index), so that threads can share work.
  Random(std::uint64_t seed, std::uint64_t index) : state_(seed) {
    state_ = next() ^ (index * 0xd1342543de82ef95u);
    state_ = next();
  }

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  /// In [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// In [0, n); n > 0. The bias is below n / 2^64.
  std::uint64_t below(std::uint64_t n) { return next() % n; }

  /// Uniform on the unit sphere, by rejection: sine and cosine differ between C libraries.
  accel::geometry::Vec3d direction() {
    for (;;) {
      const accel::geometry::Vec3d p{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      const double square = accel::geometry::dot(p, p);
      if (square > 1e-6 && square <= 1) return p * (1 / std::sqrt(square));
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace sightline::tests
