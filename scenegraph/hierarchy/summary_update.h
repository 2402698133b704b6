// Updates summaries: visits edited nodes and the nodes above them only.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "scenegraph/hierarchy/changed_groups.h"
#include "scenegraph/hierarchy/node_summary.h"

namespace sightline::scenegraph::hierarchy {

/// The revision that changed a node last. Deleted nodes may have an entry too.
using ChangeMap = model::PersistentMap<std::uint64_t>;

class SummaryTree;

/// A hierarchy and its summaries.
struct Hierarchy {
  NodeMap nodes;
  /// The scene's roots, shared among revisions as nodes are. Never null.
  std::shared_ptr<const model::ChildList> roots = std::make_shared<const model::ChildList>();
  SummaryMap summaries;
  /// The sums of groups with more than SummaryTree::kWide children; 0 stands for the scene.
  model::PersistentMap<std::shared_ptr<const SummaryTree>> summary_trees;
  /// The revision that changed a node last, since it left the static tree. Nodes without an entry,
  /// here and above them, are in the static tree; see revision/mobility.h.
  ChangeMap changed_at;

  /// The node; null if there is none.
  const model::Node* find(model::NodeId id) const {
    const std::shared_ptr<const model::Node>* node = nodes.find(id);
    return node == nullptr ? nullptr : node->get();
  }
  /// The summary of a node; 0 stands for the whole scene.
  NodeSummary summary(model::NodeId id) const;
  NodeSummary summary(const model::Node& node) const;
  /// The summary of a node that has children.
  const NodeSummary& group(model::NodeId id) const { return **summaries.find(id); }
};

/// Whether test(id) is true for the node or for one above it; false if `id` is 0.
template <class Test>
bool any_upward(const Hierarchy& hierarchy, model::NodeId id, const Test& test) {
  while (id != 0 && !test(id)) id = hierarchy.find(id)->parent;
  return id != 0;
}

/// World transform of a node: its ancestors' transforms applied from the root down, in double.
model::Affine world_from_local(const Hierarchy& hierarchy, const model::Node& node);

/// Calls visit(node, world_from_local, local_from_world) for each instance that rays can meet: no
/// node is flat from the root down to it, and all transforms together are invertible. The order is
/// that of a walk.
template <class Visit>
void for_each_reached(const Hierarchy& hierarchy, const Visit& visit) {
  struct Siblings {
    model::ChildList::Iterator next, end;
    model::Affine world_from_parent;
  };
  std::vector<Siblings> path{{hierarchy.roots->begin(), hierarchy.roots->end(), {}}};
  while (!path.empty()) {
    Siblings& siblings = path.back();
    if (siblings.next == siblings.end) {
      path.pop_back();
      continue;
    }
    const model::Node& node = *hierarchy.find(*siblings.next);
    ++siblings.next;
    if (node.is_flat) continue;
    const model::Affine world = node.parent == 0
                                    ? node.parent_from_local
                                    : compose(siblings.world_from_parent, node.parent_from_local);
    if (is_instance(node)) {
      if (const std::optional<model::Affine> back = inverse(world)) visit(node, world, *back);
    }
    if (!node.children.empty()) path.push_back({node.children.begin(), node.children.end(), world});
  }
}

/// The children of a group; 0 stands for the scene.
const model::ChildList& children_of(const Hierarchy& in, model::NodeId group);

/// What the child adds to the group's summary; empty if it is not one of its children.
NodeSummary summary_of_child(const Hierarchy& in, model::NodeId group, model::NodeId child);

/// Updates the summaries of one revision. Cost: each group above an edited node once, by its edited
/// children; by all its children if the edited ones alone reached an extreme, or are more than a
/// quarter, unless a SummaryTree holds their sum.
class SummaryUpdate {
 public:
  /// `after.summaries` is still that of `before`.
  SummaryUpdate(const Hierarchy& before, Hierarchy& after);

  /// Must be called once for each node that was made, changed or deleted.
  void edited(model::NodeId id);

  /// Updates after.summaries, after the last edited(). Returns false soon after `cancelled` is
  /// true, and where the hierarchy is deeper than kMaxDepth; the summaries are then not all up to
  /// date.
  bool finish(const std::atomic<bool>* cancelled = nullptr);

 private:
  using Children = ChangedGroups::Children;

  bool is_parent(model::NodeId id) const;
  /// Returns the group's new height.
  std::uint32_t update(model::NodeId group, const Children& changed);
  NodeSummary tree_sum(model::NodeId group, const Children& changed);
  bool adjust(model::NodeId group, const Children& changed, NodeSummary& sum) const;
  NodeSummary sum_of(model::NodeId group, const model::ChildList& children) const;

  const Hierarchy& before_;
  Hierarchy& after_;
  SummaryMap::Edit summaries_{after_.summaries};
  model::PersistentMap<std::shared_ptr<const SummaryTree>>::Edit summary_trees_{
      after_.summary_trees};
  ChangedGroups changed_{after_.nodes};
};

}  // namespace sightline::scenegraph::hierarchy
