// Where a tree's references come from.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "accel/build/box_ref.h"

namespace sightline::accel {

/// Threads: all functions, any, several at once; they are pure.
struct ReferenceSource {
  /// The coarsest references, which the root is expanded from, have places from 0 to `count`. Not
  /// every place has to hold one.
  std::size_t count = 0;
  /// Writes those at places from `begin` to `end`, and returns how many they are. Counts what it
  /// prepares.
  std::function<std::size_t(std::size_t begin, std::size_t end, BoxRef* out, BuildCounters&)> list;
  /// Appends what an openable reference stands for, openable ones among it or not. Their boxes lie
  /// within its own. The same reference always opens into the same ones. Null: none is openable.
  std::function<void(const BoxRef&, std::vector<BoxRef>&)> open{};
  /// Keeps alive what the functions read. If null, only threads that hold it by other means call
  /// them: idle threads are not called to help.
  std::shared_ptr<const void> alive{};
};

/// A source of references that are made already.
inline ReferenceSource source_of(std::span<const BoxRef> refs) {
  return {.count = refs.size(),
          .list = [refs](std::size_t begin, std::size_t end, BoxRef* out, BuildCounters& counters) {
            counters.touches_prepare += end - begin;
            std::copy(refs.begin() + static_cast<std::ptrdiff_t>(begin),
                      refs.begin() + static_cast<std::ptrdiff_t>(end), out);
            return end - begin;
          }};
}

}  // namespace sightline::accel
