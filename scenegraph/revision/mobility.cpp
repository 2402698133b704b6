// Sorts changed nodes into the static and the dynamic tree.
#include "scenegraph/revision/mobility.h"

#include <algorithm>

namespace sightline::scenegraph::revision {
namespace {

bool differs(const model::Node* old, const model::Node* node) {
  return old == nullptr || node == nullptr || old->parent != node->parent ||
         old->parent_from_local != node->parent_from_local || old->mesh != node->mesh ||
         old->mask != node->mask || old->mobility != node->mobility;
}

class ChangeClassifier {
 public:
  ChangeClassifier(const Snapshot& base, const EditedNodes& edited,
                   const std::atomic<bool>* cancelled)
      : base_(base.hierarchy()),
        edited_(edited),
        cancelled_(cancelled),
        opened_(base.shared_trees().static_tree->instances_so_far() != nullptr) {
    change_.dynamic_roots = base_.dynamic_roots;
    if (base.shared_trees().removed != nullptr)
      change_.removed = base.shared_trees().removed->nodes();
  }

  MobilityChange classify() {
    for (const auto& [id, node] : edited_) {
      if (differs(base_.find(id), node.get())) change_.changed.push_back(id);
    }
    std::sort(change_.changed.begin(), change_.changed.end());
    instances::NodeSet::Edit dynamic_roots(change_.dynamic_roots);
    instances::NodeSet::Edit removed(change_.removed);
    for (const model::NodeId id : change_.changed) {
      if (cancelled_ != nullptr && cancelled_->load(std::memory_order_relaxed)) break;
      leave(id, removed);
      arrive(id, dynamic_roots);
    }
    return std::move(change_);
  }

 private:
  /// The node as the base has it.
  void leave(model::NodeId id, instances::NodeSet::Edit& removed) {
    if (base_.find(id) == nullptr) return;
    if (scenegraph::instances::is_dynamic(base_, id)) {
      change_.dynamic_changed = true;
    } else if (opened_) {
      removed.set(id, true);
    } else {
      change_.static_changed = true;
      // Dynamic nodes below it move with it. Rays have opened neither tree, so a new one costs
      // little.
      if (base_.dynamic_roots.size() > 0) change_.dynamic_changed = true;
    }
  }

  /// The node as the new revision has it.
  void arrive(model::NodeId id, instances::NodeSet::Edit& dynamic_roots) {
    const model::Node* node = edited_.find(id)->second.get();
    const bool moves = node != nullptr && is_dynamic(id);
    if (moves) change_.dynamic_changed = true;
    if (node != nullptr && !moves) change_.static_changed = true;
    const bool topmost = moves && !is_dynamic(node->parent);
    if (topmost != (base_.dynamic_roots.find(id) != nullptr)) dynamic_roots.set(id, topmost);
  }

  const model::Node* find(model::NodeId id) const {
    const auto found = edited_.find(id);
    return found != edited_.end() ? found->second.get() : base_.find(id);
  }

  /// In the new revision: whether the node or one above it is a dynamic root.
  bool is_dynamic(model::NodeId id) {
    if (id == 0) return false;
    const auto known = known_.find(id);
    if (known != known_.end()) return known->second;
    const bool moves = becomes_dynamic(id) || is_dynamic(find(id)->parent);
    known_[id] = moves;
    return moves;
  }

  bool becomes_dynamic(model::NodeId id) const {
    const model::Node* old = base_.find(id);
    const bool was_dynamic = base_.dynamic_roots.find(id) != nullptr;
    if (!std::binary_search(change_.changed.begin(), change_.changed.end(), id)) return was_dynamic;
    const model::Node& node = *find(id);
    return opened_ || node.mobility != model::Mobility::kStatic ||
           (was_dynamic && old->mobility == node.mobility);
  }

  const hierarchy::Hierarchy& base_;
  const EditedNodes& edited_;
  const std::atomic<bool>* const cancelled_;
  const bool opened_;
  std::unordered_map<model::NodeId, bool> known_;
  MobilityChange change_;
};

}  // namespace

MobilityChange classify_changes(const Snapshot& base, const EditedNodes& edited,
                                const std::atomic<bool>* cancelled) {
  return ChangeClassifier(base, edited, cancelled).classify();
}

instances::NodeSet topmost_of(const hierarchy::Hierarchy& hierarchy,
                              std::span<const model::NodeId> nodes) {
  std::vector<model::NodeId> sorted(nodes.begin(), nodes.end());
  std::sort(sorted.begin(), sorted.end());
  const auto is_among = [&](model::NodeId id) {
    return any_upward(hierarchy, id, [&](model::NodeId above) {
      return std::binary_search(sorted.begin(), sorted.end(), above);
    });
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
