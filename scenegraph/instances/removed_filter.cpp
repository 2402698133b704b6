// Looking up the hierarchy for what has left.
#include "scenegraph/instances/removed_filter.h"

#include <utility>

namespace sightline::scenegraph::instances {

Departed::Departed(std::shared_ptr<const SceneHalf> half, NodeSet nodes)
    : half_(std::move(half)), nodes_(std::move(nodes)), states_(half_->instances().size()) {}

bool Departed::decide(std::size_t index) const {
  bool gone = false;
  for (model::NodeId id = half_->instances()[index].node; id != 0 && !gone;
       id = half_->hierarchy().find(id)->parent)
    gone = nodes_.find(id) != nullptr;
  states_[index].store(gone ? State::kGone : State::kThere, std::memory_order_relaxed);
  return gone;
}

}  // namespace sightline::scenegraph::instances
