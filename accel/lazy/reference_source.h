// Where a tree's references come from.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "accel/tree/box_list.h"

namespace sightline::accel {

/// Threads: all functions, any, several at once; they are pure.
struct ReferenceSource {
  /// Slice `slice` of the coarsest references: what the root is expanded from. Counts what it
  /// prepares.
  std::function<BoxList(std::size_t slice, BuildCounters&)> list;
  std::size_t slices = 1;
  /// Appends what an openable reference stands for, openable ones among it or not. Their boxes lie
  /// within its own. The same reference always opens into the same ones. Null: none is openable.
  std::function<void(const BoxRef&, std::vector<BoxRef>&)> open{};
  /// Keeps alive what the functions read. If null, only threads that hold it by other means call
  /// them: idle threads are not called to help.
  std::shared_ptr<const void> alive{};
};

}  // namespace sightline::accel
