// What has left the static half since that was made: its tree still holds it, and rays pass it by.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "scenegraph/instances/lazy_array.h"
#include "scenegraph/instances/scene_half.h"
#include "scenegraph/model/persistent_map.h"

namespace sightline::scenegraph::instances {

using NodeSet = model::PersistentMap<bool>;

/// Shared by all revisions between which nothing more departs. Whether an instance has departed is
/// decided when a ray first comes to it, by looking up the hierarchy, and then remembered: making
/// one costs nothing, however large the scene. Threads: any.
class Departed {
 public:
  /// `nodes`: with all that was below them when the half was made. It has been begun.
  Departed(std::shared_ptr<const SceneHalf> half, NodeSet nodes);

  const NodeSet& nodes() const { return nodes_; }
  /// `index`: an instance's place in the half, which has been opened.
  bool has(std::size_t index) const {
    const State state = states_[index].load(std::memory_order_relaxed);
    return state == State::kUnknown ? decide(index) : state == State::kGone;
  }

 private:
  enum class State : std::uint8_t { kUnknown, kThere, kGone };

  bool decide(std::size_t index) const;

  std::shared_ptr<const SceneHalf> half_;
  NodeSet nodes_;
  Zeroed<std::atomic<State>> states_;
};

}  // namespace sightline::scenegraph::instances
