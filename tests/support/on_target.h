// Chooses the SIMD target of all kernels.
#pragma once

#include <hwy/highway.h>

#include <cstdint>

namespace sightline::tests {

/// Selects the kernels of one SIMD target for the lifetime of this object. No other thread may be
/// working when it is made or destroyed.
class OnTarget {
 public:
  explicit OnTarget(std::int64_t target) { hwy::SetSupportedTargetsForTest(target); }
  ~OnTarget() { hwy::SetSupportedTargetsForTest(0); }
  OnTarget(const OnTarget&) = delete;
  OnTarget& operator=(const OnTarget&) = delete;
};

}  // namespace sightline::tests
