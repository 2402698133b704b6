// The static and the dynamic tree of a scene. The static tree is shared by many revisions, the
// dynamic tree is made again for each revision that moves something.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>

#include "scenegraph/instances/instance_filter.h"
#include "scenegraph/instances/instance_list.h"
#include "scenegraph/model/persistent_map.h"

namespace sightline::scenegraph::instances {

/// One of the two trees. Its instances are made when a ray first needs them. Immutable apart from
/// opening and growing. Threads: all members, any; no thread waits for another.
class SceneTree {
 public:
  SceneTree(MobilitySide side, hierarchy::Hierarchy hierarchy)
      : side_(side), hierarchy_(std::move(hierarchy)) {}
  ~SceneTree();
  SceneTree(const SceneTree&) = delete;
  SceneTree& operator=(const SceneTree&) = delete;

  /// Of the revision that this tree was made for.
  const hierarchy::Hierarchy& hierarchy() const { return hierarchy_; }
  /// Makes the instances at the first call. Throws std::bad_alloc.
  const Instances& instances() const;
  /// Null until instances() has been called.
  const Instances* instances_so_far() const;

 private:
  const MobilitySide side_;
  const hierarchy::Hierarchy hierarchy_;
  mutable std::atomic<const Instances*> instances_{nullptr};
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

/// The trees of a revision, shared with the revisions that have the same.
struct SceneTrees {
  std::shared_ptr<const SceneTree> static_tree, dynamic_tree;
  std::shared_ptr<const RemovedFilter> removed;  ///< From the static tree; null: none.
};

/// The trees of a revision, opened for rays: the instances of both have one numbering, static ones
/// first. A view, valid while the snapshot is.
struct OpenTrees {
  const Instances& static_tree;
  const Instances& dynamic_tree;
  const RemovedFilter* removed = nullptr;  ///< From the static tree; null: none.

  /// Removed instances are counted; rays never meet them.
  std::size_t size() const { return static_tree.size() + dynamic_tree.size(); }
  const Instance& operator[](std::size_t index) const {
    return index < static_tree.size() ? static_tree[index]
                                      : dynamic_tree[index - static_tree.size()];
  }
};

}  // namespace sightline::scenegraph::instances
