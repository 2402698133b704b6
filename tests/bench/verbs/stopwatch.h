// Time since construction: of the wall, or of the process.
#pragma once

#include <ctime>

namespace sightline::bench {

class Stopwatch {
 public:
  /// From now on, processor time of all threads: what else runs on the machine does not count. For
  /// what one thread does; before any is made.
  static void use_processor_time() { clock_ = CLOCK_PROCESS_CPUTIME_ID; }

  double seconds() const { return now() - start_; }

 private:
  static double now() {
    timespec time{};
    clock_gettime(clock_, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }

  inline static clockid_t clock_ = CLOCK_MONOTONIC;
  double start_ = now();
};

}  // namespace sightline::bench
