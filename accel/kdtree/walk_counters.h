// The work of walks, in the units of docs/benchmarks.md.
#pragma once

#include <cstdint>

namespace sightline::accel::kdtree {

/// Each ray of a packet counts by itself.
struct WalkCounters {
  std::uint64_t steps = 0;  ///< Inner nodes visited.
  std::uint64_t tests = 0;  ///< Triangles tested, searches of deferred cells included.

  WalkCounters& operator+=(const WalkCounters& o) {
    steps += o.steps;
    tests += o.tests;
    return *this;
  }
};

}  // namespace sightline::accel::kdtree
