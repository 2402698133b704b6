// Grows both children of a cell in parallel.
#pragma once

#include <cstddef>

#include <tbb/task_group.h>

namespace sightline::accel::grow {

/// Children of at least this many references each are grown in parallel.
inline constexpr std::size_t kForkFrom = 4096;

/// Runs both; `right` is a task for any thread of the arena. If one throws, the exception is
/// rethrown after both have ended.
template <class Left, class Right>
void fork(Left&& left, Right&& right) {
  tbb::task_group group;
  group.run(right);
  try {
    left();
  } catch (...) {
    group.cancel();
    group.wait();
    throw;
  }
  group.wait();
}

}  // namespace sightline::accel::grow
