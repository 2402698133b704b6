// Flushes denormal numbers to zero on the calling thread.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace sightline::tests {

#if defined(__SSE2__)

/// Flushes denormal results during its lifetime; with `inputs`, also treats denormal operands as
/// zero.
class FlushDenormals {
 public:
  explicit FlushDenormals(bool inputs) : before_(_mm_getcsr()) {
    constexpr unsigned kDenormalsAreZero = 0x40;
    _mm_setcsr(before_ | _MM_FLUSH_ZERO_ON | (inputs ? kDenormalsAreZero : 0));
  }
  ~FlushDenormals() { _mm_setcsr(before_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned before_;
};

#endif

}  // namespace sightline::tests
