// The time that an expansion takes.
#pragma once

#include <chrono>

#include "accel/kdtree/reference.h"

namespace sightline::accel::lazy {

/// Adds the time between its construction and its destruction to the counters.
class Timed {
 public:
  explicit Timed(kdtree::BuildCounters& counters) : counters_(counters) {}
  ~Timed() {
    counters_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 private:
  kdtree::BuildCounters& counters_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace sightline::accel::lazy
