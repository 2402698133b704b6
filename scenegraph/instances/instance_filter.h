// A yes or no for each instance, decided at the first question and then remembered.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "scenegraph/instances/instance_list.h"
#include "scenegraph/instances/lazy_array.h"
#include "scenegraph/model/persistent_map.h"

namespace sightline::scenegraph::instances {

class SceneTree;

/// The memory of a filter. Making one takes no time in proportion to the scene. Threads: any; two
/// threads may decide the same instance, with the same result.
class InstanceFilter {
 public:
  explicit InstanceFilter(std::size_t instances) : states_(instances) {}

  /// Calls decide() the first time. Throws std::bad_alloc.
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

using NodeSet = model::PersistentMap<bool>;

/// The instances removed from the static tree since it was made. The tree still holds them; rays
/// skip them. Revisions with the same removed nodes share one filter. Threads: any.
class RemovedFilter {
 public:
  /// `nodes` are removed with all that was below them when the tree was made. Rays have opened the
  /// tree.
  RemovedFilter(std::shared_ptr<const SceneTree> tree, NodeSet nodes);

  const NodeSet& nodes() const { return nodes_; }
  /// `index`: of an opened instance of the tree.
  bool has(std::size_t index) const {
    return removed_.passes(index, [&] { return decide(index); });
  }

 private:
  bool decide(std::size_t index) const;

  std::shared_ptr<const SceneTree> tree_;
  NodeSet nodes_;
  InstanceFilter removed_;
};

}  // namespace sightline::scenegraph::instances
