// Records the changes that make nodes leave their trees.
#include "scenegraph/revision/mobility.h"

#include <algorithm>

namespace sightline::scenegraph::revision {
namespace {

bool differs(const model::Node* old, const model::Node* node) {
  return old == nullptr || node == nullptr || old->parent != node->parent ||
         old->parent_from_local != node->parent_from_local || old->mesh != node->mesh ||
         old->mask != node->mask || old->mobility != node->mobility;
}

/// Whether a node that changed before rays opened the static tree stays out of that tree.
bool begins_dynamic(const model::Node* old, const model::Node* node, bool was_dynamic) {
  if (node == nullptr) return false;
  return node->mobility != model::Mobility::kStatic ||
         (was_dynamic && old->mobility == node->mobility);
}

}  // namespace

MobilityChange classify_changes(const Snapshot& base, const EditedNodes& edited,
                                const std::atomic<bool>* cancelled) {
  const hierarchy::Hierarchy& before = base.hierarchy();
  const std::uint64_t revision = base.revision() + 1;
  MobilityChange change;
  change.opened = base.shared_trees().static_tree()->instances_so_far() != nullptr;
  change.changed_at = before.changed_at;
  for (const auto& [id, node] : edited) {
    if (differs(before.find(id), node.get())) change.changed.push_back(id);
  }
  std::sort(change.changed.begin(), change.changed.end());
  hierarchy::ChangeMap::Edit changed_at(change.changed_at);
  for (const model::NodeId id : change.changed) {
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) break;
    const bool was_dynamic = before.changed_at.find(id) != nullptr;
    const bool leaves = change.opened ||
                        begins_dynamic(before.find(id), edited.find(id)->second.get(), was_dynamic);
    changed_at.set(id, leaves ? revision : 0);
  }
  return change;
}

}  // namespace sightline::scenegraph::revision
