// Keeping what is known of subtrees up to date: only edited nodes and those above them are looked
// at.
#pragma once

#include <memory_resource>
#include <unordered_map>
#include <vector>

#include "scenegraph/hierarchy/node_summary.h"

namespace sightline::scenegraph::hierarchy {

using NodeMap = model::PersistentMap<std::shared_ptr<const model::Node>>;

class WideSum;

/// A hierarchy and what is known of it.
struct Hierarchy {
  NodeMap nodes;
  /// Shared among revisions, as nodes are. Never null.
  std::shared_ptr<const std::vector<model::NodeId>> roots =
      std::make_shared<const std::vector<model::NodeId>>();
  SubtreeMap subtrees;
  /// Of the groups of very many children, and of the scene if it has so many roots.
  model::PersistentMap<std::shared_ptr<const WideSum>> wide;
  /// The nodes that are in the dynamic tree with all that is below them; see movers.h.
  model::PersistentMap<bool> movers;

  /// Null if there is no such node.
  const model::Node* find(model::NodeId id) const {
    const std::shared_ptr<const model::Node>* node = nodes.find(id);
    return node == nullptr ? nullptr : node->get();
  }
  /// 0: the whole scene.
  Subtree subtree(model::NodeId id) const;
  Subtree subtree(const model::Node& node) const;
  /// Of a node that has children.
  const Subtree& group(model::NodeId id) const { return **subtrees.find(id); }
};

/// World transform of a node: its ancestors' transforms applied from the root down, in double.
model::Affine world_from_local(const Hierarchy& hierarchy, const model::Node& node);

/// 0: the roots.
const std::vector<model::NodeId>& children_of(const Hierarchy& in, model::NodeId group);

/// What the child brings to the group; nothing where it is not one of its children.
Subtree part_of_child(const Hierarchy& in, model::NodeId group, model::NodeId child);

/// For one revision. Cost: each group above an edited node once, by its edited children; or, where
/// those were its outermost, by all of its children, as far as those are not many (see WideSum).
class SubtreeUpdate {
 public:
  /// `after.subtrees` is still that of `before`.
  SubtreeUpdate(const Hierarchy& before, Hierarchy& after);

  /// To be called for each node that was made, changed or deleted, once.
  void edited(model::NodeId id);

  /// After the last: brings after.subtrees up to date.
  void finish();

 private:
  /// Of the groups at one depth, the children that bring something else than before.
  using Children = std::pmr::vector<model::NodeId>;
  using Changes = std::pmr::unordered_map<model::NodeId, Children>;

  bool is_parent(model::NodeId id) const;
  std::size_t depth(model::NodeId id);
  Changes& changes_at(model::NodeId group) { return changes_[depth(group)]; }
  void update(model::NodeId group, const Children& changed);
  Subtree wide_sum_of(model::NodeId group, const Children& changed);
  bool adjust(model::NodeId group, const Children& changed, Subtree& sum) const;
  Subtree sum_of(model::NodeId group, const std::vector<model::NodeId>& children) const;

  const Hierarchy& before_;
  Hierarchy& after_;
  SubtreeMap::Edit subtrees_{after_.subtrees};
  model::PersistentMap<std::shared_ptr<const WideSum>>::Edit wide_{after_.wide};
  std::pmr::monotonic_buffer_resource memory_;
  std::vector<Changes> changes_;  // by depth: the scene's is 0, a root's is 1
  model::NodeId last_ = 0;        // whose depth was asked for last
  std::size_t last_depth_ = 0;
};

}  // namespace sightline::scenegraph::hierarchy
