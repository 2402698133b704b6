// Grows both children of a node of a plain kd-tree in parallel.
#pragma once

#include <optional>
#include <thread>

#include "accel/grow/fork.h"
#include "accel/published/kd/plain_growth.h"

namespace sightline::accel::published::kd {

/// Runs grow_left() here and grow_right(task, goes_on) on any thread. If `goes_on`, the thread that
/// has grown the left child continues with the same task; otherwise the right cells are written
/// elsewhere, and appended once both have ended. The order of the cells is the same either way.
template <class GrowLeft, class GrowRight>
PlainCells::Pair fork_children(const PlainTask& task, const GrowLeft& grow_left,
                               const GrowRight& grow_right) {
  PlainCells::Pair children;
  std::optional<PlainWriter> other;
  kdtree::BuildCounters counters;
  bool left_is_grown = false;
  const auto left = [&] {
    children[0] = grow_left();
    left_is_grown = true;
  };
  grow::fork(left, [&, thread = std::this_thread::get_id()] {
    if (std::this_thread::get_id() == thread && left_is_grown) {
      children[1] = grow_right(task, true);
      return;
    }
    other.emplace(task.out.capacity());
    children[1] = grow_right(PlainTask{*other, counters}, false);
  });
  if (!other) return children;
  task.counters += counters;
  children[1] = task.out.append(*other, children[1]);
  return children;
}

}  // namespace sightline::accel::published::kd
