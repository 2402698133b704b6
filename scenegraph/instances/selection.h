// The part of a scene that a query sees: what is under one node, less what is under others.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/result.h"
#include "scenegraph/instances/lazy_array.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::instances {

/// Decided for an instance when a ray first comes to it, by looking up the hierarchy, and then
/// remembered: making one costs nothing, however large the scene. Threads: any.
class Selection {
 public:
  /// `root` and all nodes under it, 0: the whole scene; less each node of `excluded` and all under
  /// it. Keeps the snapshot, which must be what is traced.
  /// Errors: kNotFound, naming the id that is no node of this revision.
  static Result<Selection> make(std::shared_ptr<const revision::Snapshot> snapshot,
                                model::NodeId root, std::span<const model::NodeId> excluded);

  /// `index`: an instance's place, which has been opened.
  bool selects(std::size_t index) const {
    const State state = states_[index].load(std::memory_order_relaxed);
    return state == State::kUnknown ? decide(index) : state == State::kIn;
  }

 private:
  enum class State : std::uint8_t { kUnknown, kIn, kOut };

  Selection(std::shared_ptr<const revision::Snapshot> snapshot, model::NodeId root,
            std::vector<model::NodeId> excluded);
  bool decide(std::size_t index) const;
  bool contains(model::NodeId id) const;

  std::shared_ptr<const revision::Snapshot> snapshot_;
  model::NodeId root_;
  std::vector<model::NodeId> excluded_;  // ascending
  Zeroed<std::atomic<State>> states_;
};

}  // namespace sightline::scenegraph::instances
