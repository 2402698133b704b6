// Numbers on which arithmetic fails, from a fuzzer's bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>

#include "tests/fuzz/bytes.h"

namespace sightline::tests {

/// Any number: NaN, infinite, denormal, huge; often a small integer.
inline float take_float(Bytes& bytes) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  static constexpr float kHostile[] = {kInf,    -kInf,    std::numeric_limits<float>::quiet_NaN(),
                                       3.4e38f, -3.4e38f, 1.1754944e-38f,
                                       1e-45f,  -1e-45f,  1e20f,
                                       1e-20f,  0.5f,     16777216.0f,
                                       1e6f,    -1e9f,    1.0000001f,
                                       -0.0f};
  const std::size_t kind = bytes.below(64);
  if (kind < std::size(kHostile)) return kHostile[kind];
  if (kind < 48) return static_cast<float>(bytes.take<std::int8_t>());
  return bytes.take<float>();
}

inline double take_double(Bytes& bytes) {
  static constexpr double kHostile[] = {1e308, -1e308, 5e-324, 1e-300, 1e18, 1e10, 25, 1000};
  const std::size_t kind = bytes.below(32);
  if (kind < std::size(kHostile)) return kHostile[kind];
  if (kind < 24) return static_cast<double>(take_float(bytes));
  return bytes.take<double>();
}

}  // namespace sightline::tests
