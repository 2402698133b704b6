// Growing both children of a cell at once.
#pragma once

#include <cstddef>

#include <tbb/task_group.h>

namespace sightline::accel::grow {

/// Children with at least this many references each are worth a task.
inline constexpr std::size_t kForkFrom = 4096;

/// Runs both, `right` as a task that any thread of the arena may take. Throws what either throws,
/// when neither runs any more.
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
