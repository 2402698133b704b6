// Whether each instance passes a filter, decided at the first question and then remembered.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "scenegraph/instances/lazy_array.h"

namespace sightline::scenegraph::instances {

/// The memory of a filter. Making one takes no time in proportion to the scene. Threads: any; two
/// threads may decide the same instance, with the same result.
class InstanceFilter {
 public:
  explicit InstanceFilter(std::size_t instances) : states_(instances) {}

  /// Whether the instance passes: what decide() returns the first time. Throws std::bad_alloc.
  template <class Decide>
  bool passes(std::size_t index, const Decide& decide) const {
    const State state = states_[index].load(std::memory_order_relaxed);
    if (state != State::kUnknown) return state == State::kYes;
    const bool yes = decide();
    states_[index].store(yes ? State::kYes : State::kNo, std::memory_order_relaxed);
    return yes;
  }

 private:
  enum class State : std::uint8_t { kUnknown, kYes, kNo };

  LazyArray<std::atomic<State>> states_;
};

}  // namespace sightline::scenegraph::instances
