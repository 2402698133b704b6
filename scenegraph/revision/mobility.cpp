// Marking nodes as moving.
#include "scenegraph/revision/mobility.h"

#include <algorithm>

namespace sightline::scenegraph::revision {
namespace {

bool differs(const model::Node* old, const model::Node* node) {
  return old == nullptr || node == nullptr || old->parent != node->parent ||
         old->parent_from_local != node->parent_from_local || old->mesh != node->mesh ||
         old->mask != node->mask || old->mobility != node->mobility;
}

class Marking {
 public:
  Marking(const Snapshot& base, const EditedNodes& edited)
      : base_(base.hierarchy()),
        edited_(edited),
        begun_(base.halves().still->instances_so_far() != nullptr) {
    marked_.movers = base_.movers;
    if (base.halves().departed != nullptr) marked_.departed = base.halves().departed->nodes();
  }

  Marked mark() {
    for (const auto& [id, node] : edited_) {
      if (differs(base_.find(id), node.get())) marked_.changed.push_back(id);
    }
    std::sort(marked_.changed.begin(), marked_.changed.end());
    instances::NodeSet::Edit movers(marked_.movers);
    instances::NodeSet::Edit departed(marked_.departed);
    for (const model::NodeId id : marked_.changed) {
      leave(id, departed);
      arrive(id, movers);
    }
    return std::move(marked_);
  }

 private:
  void leave(model::NodeId id, instances::NodeSet::Edit& departed) {
    if (base_.find(id) == nullptr) return;
    if (scenegraph::instances::is_moving(base_, id)) {
      marked_.moving_changed = true;
    } else if (begun_) {
      departed.set(id, true);
    } else {
      marked_.still_changed = true;
    }
  }

  void arrive(model::NodeId id, instances::NodeSet::Edit& movers) {
    const model::Node* node = edited_.find(id)->second.get();
    const bool moves = node != nullptr && is_moving(id);
    if (moves) marked_.moving_changed = true;
    if (node != nullptr && !moves) marked_.still_changed = true;
    const bool topmost = moves && !is_moving(node->parent);
    if (topmost != (base_.movers.find(id) != nullptr)) movers.set(id, topmost);
  }

  const model::Node* find(model::NodeId id) const {
    const auto found = edited_.find(id);
    return found != edited_.end() ? found->second.get() : base_.find(id);
  }

  /// From now on: the node, or one above it.
  bool is_moving(model::NodeId id) {
    if (id == 0) return false;
    const auto known = known_.find(id);
    if (known != known_.end()) return known->second;
    const bool moves = begins_to_move(id) || is_moving(find(id)->parent);
    known_[id] = moves;
    return moves;
  }

  bool begins_to_move(model::NodeId id) const {
    const model::Node* old = base_.find(id);
    const bool moved_before = base_.movers.find(id) != nullptr;
    if (!std::binary_search(marked_.changed.begin(), marked_.changed.end(), id))
      return moved_before;
    const model::Node& node = *find(id);
    return begun_ || node.mobility != model::Mobility::kStatic ||
           (moved_before && old->mobility == node.mobility);
  }

  const hierarchy::Hierarchy& base_;
  const EditedNodes& edited_;
  const bool begun_;
  std::unordered_map<model::NodeId, bool> known_;
  Marked marked_;
};

}  // namespace

Marked mark_movers(const Snapshot& base, const EditedNodes& edited) {
  return Marking(base, edited).mark();
}

instances::NodeSet topmost_of(const hierarchy::Hierarchy& hierarchy,
                              std::span<const model::NodeId> nodes) {
  std::vector<model::NodeId> sorted(nodes.begin(), nodes.end());
  std::sort(sorted.begin(), sorted.end());
  const auto is_among = [&](model::NodeId id) {
    for (; id != 0; id = hierarchy.find(id)->parent) {
      if (std::binary_search(sorted.begin(), sorted.end(), id)) return true;
    }
    return false;
  };
  instances::NodeSet topmost;
  instances::NodeSet::Edit edit(topmost);
  for (const model::NodeId id : sorted) {
    const model::Node* node = hierarchy.find(id);
    if (node != nullptr && !is_among(node->parent)) edit.set(id, true);
  }
  return topmost;
}

}  // namespace sightline::scenegraph::revision
