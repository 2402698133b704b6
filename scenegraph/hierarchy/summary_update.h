// Updates summaries: visits edited nodes and the nodes above them only.
#pragma once

#include <atomic>
#include <memory_resource>
#include <unordered_map>
#include <vector>

#include "scenegraph/hierarchy/node_summary.h"

namespace sightline::scenegraph::hierarchy {

using NodeMap = model::PersistentMap<std::shared_ptr<const model::Node>>;

/// Revisions by node. Deleted nodes may have an entry too.
using ChangeMap = model::PersistentMap<std::uint64_t>;

class SummaryTree;

/// A hierarchy and its summaries.
struct Hierarchy {
  NodeMap nodes;
  /// Shared among revisions, as nodes are. Never null.
  std::shared_ptr<const model::ChildList> roots = std::make_shared<const model::ChildList>();
  SummaryMap summaries;
  /// For groups with more than SummaryTree::kWide children (0: the scene's roots).
  model::PersistentMap<std::shared_ptr<const SummaryTree>> summary_trees;
  /// By node: the revision that changed it last, since it left the static tree. Nodes without an
  /// entry, here and above them, are in the static tree; see revision/mobility.h.
  ChangeMap changed_at;

  /// Null if there is no such node.
  const model::Node* find(model::NodeId id) const {
    const std::shared_ptr<const model::Node>* node = nodes.find(id);
    return node == nullptr ? nullptr : node->get();
  }
  /// 0: the whole scene.
  NodeSummary summary(model::NodeId id) const;
  NodeSummary summary(const model::Node& node) const;
  /// Of a node that has children.
  const NodeSummary& group(model::NodeId id) const { return **summaries.find(id); }
};

/// Whether test(id) is true for the node or for one above it. `id` may be 0: then it is false.
template <class Test>
bool any_upward(const Hierarchy& hierarchy, model::NodeId id, const Test& test) {
  while (id != 0 && !test(id)) id = hierarchy.find(id)->parent;
  return id != 0;
}

/// World transform of a node: its ancestors' transforms applied from the root down, in double.
model::Affine world_from_local(const Hierarchy& hierarchy, const model::Node& node);

/// 0: the roots.
const model::ChildList& children_of(const Hierarchy& in, model::NodeId group);

/// What the child adds to the group's summary; empty if it is not one of its children.
NodeSummary summary_of_child(const Hierarchy& in, model::NodeId group, model::NodeId child);

/// The deepest level that SummaryUpdate can hold. A subtree of kMaxDepth may hang as deep as that,
/// until its height is known.
inline constexpr int kMaxDepthHere = 2 * model::kMaxDepth;

/// For one revision. Cost: each group above an edited node once, by its edited children. If those
/// alone reached an extreme, by all its children, unless a SummaryTree holds their sum.
class SummaryUpdate {
 public:
  /// `after.summaries` is still that of `before`.
  SummaryUpdate(const Hierarchy& before, Hierarchy& after);

  /// To be called for each node that was made, changed or deleted, once.
  void edited(model::NodeId id);

  /// After the last: brings after.summaries up to date. Returns false soon after `cancelled` is
  /// true; the summaries are then not all up to date.
  bool finish(const std::atomic<bool>* cancelled = nullptr);

 private:
  /// Of the groups at one depth, the children that bring something else than before.
  using Children = std::pmr::vector<model::NodeId>;
  using Changes = std::pmr::unordered_map<model::NodeId, Children>;

  bool is_parent(model::NodeId id) const;
  std::size_t depth(model::NodeId id);
  Changes& changes_at(model::NodeId group) { return changes_[depth(group)]; }
  void update(model::NodeId group, const Children& changed);
  NodeSummary tree_sum(model::NodeId group, const Children& changed);
  bool adjust(model::NodeId group, const Children& changed, NodeSummary& sum) const;
  NodeSummary sum_of(model::NodeId group, const model::ChildList& children) const;

  const Hierarchy& before_;
  Hierarchy& after_;
  SummaryMap::Edit summaries_{after_.summaries};
  model::PersistentMap<std::shared_ptr<const SummaryTree>>::Edit summary_trees_{
      after_.summary_trees};
  std::pmr::monotonic_buffer_resource memory_;
  // By depth: the scene's is 0, a root's is 1. See kMaxDepthHere.
  std::vector<Changes> changes_;
  model::NodeId last_ = 0;  // whose depth was asked for last
  std::size_t last_depth_ = 0;
};

}  // namespace sightline::scenegraph::hierarchy
