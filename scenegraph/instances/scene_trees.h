// The trees of a scene. The static tree is shared by many revisions. What has changed since it was
// made is in dynamic trees: one for each span of revisions.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "scenegraph/instances/instance_filter.h"
#include "scenegraph/instances/instance_list.h"

namespace sightline::scenegraph::instances {

/// One of a scene's trees. Its instances are made when a ray first needs them. Immutable apart from
/// opening and growing. Threads: all members, any; no thread waits for another.
class SceneTree {
 public:
  explicit SceneTree(hierarchy::Hierarchy hierarchy)
      : hierarchy_(std::move(hierarchy)), is_static_(true) {}
  SceneTree(hierarchy::Hierarchy hierarchy, MovedNodes moved)
      : hierarchy_(std::move(hierarchy)),
        is_static_(false),
        moved_(std::make_shared<const MovedNodes>(std::move(moved))) {}
  ~SceneTree();
  SceneTree(const SceneTree&) = delete;
  SceneTree& operator=(const SceneTree&) = delete;

  /// The hierarchy of the revision that this tree was made for.
  const hierarchy::Hierarchy& hierarchy() const { return hierarchy_; }
  bool is_static() const { return is_static_; }
  /// Whether rays have asked for the instances: some thread has made them, or does so.
  bool is_wanted() const { return wanted_.load(std::memory_order_relaxed); }
  /// What a dynamic tree will hold; null once rays have opened it, when the parts are released.
  std::shared_ptr<const MovedNodes> moved() const;
  /// Makes the instances at the first call. Throws std::bad_alloc.
  const Instances& instances() const;
  /// The instances; null until instances() has opened them.
  const Instances* instances_so_far() const;

 private:
  const hierarchy::Hierarchy hierarchy_;
  const bool is_static_;
  mutable std::atomic<bool> wanted_{false};
  mutable std::mutex moved_mutex_;  // held for one copy
  mutable std::shared_ptr<const MovedNodes> moved_;
  mutable std::atomic<const Instances*> instances_{nullptr};
};

/// The instances that have left a tree since it was made: they changed, or a node above them did.
/// The tree still holds them; rays skip them. Threads: any.
class RemovedFilter {
 public:
  /// `last` is Level::last; `changed_at` is that of the revision whose rays ask. Opens nothing.
  RemovedFilter(std::shared_ptr<const SceneTree> tree, std::uint64_t last,
                hierarchy::ChangeMap changed_at);

  /// Whether an opened instance has left the tree.
  bool has(std::size_t index) const {
    return removed_.passes(index, [&] { return decide(index); });
  }

 private:
  bool decide(std::size_t index) const;

  std::shared_ptr<const SceneTree> tree_;
  std::uint64_t last_;
  hierarchy::ChangeMap changed_at_;
  InstanceFilter removed_;
};

/// A level: a tree of a revision, and what has left it. An instance is in the tree of the span of
/// revisions in which it, or a node above it, changed last; the static tree has those that did not.
struct Level {
  std::shared_ptr<const SceneTree> tree{};
  std::shared_ptr<const RemovedFilter> removed{};  ///< The instances that have left; null if none.
  /// The last revision whose changes it holds; the static tree: 0 until others are merged into it.
  std::uint64_t last = 0;
  /// The number of nodes that had changed when it was made; for the static tree the number of
  /// instances, once rays have opened it.
  std::uint64_t nodes = 0;
  std::uint64_t left = 0;  ///< The number of `nodes` that left; a little too many for groups.

  std::uint64_t staying() const { return nodes - std::min(nodes, left); }
};

/// The trees of a revision, shared with the revisions that have the same.
struct SceneTrees {
  std::vector<Level> levels;  ///< The trees in the order of `last`, the static tree first.

  const std::shared_ptr<const SceneTree>& static_tree() const { return levels.front().tree; }
  /// Whether rays have opened all trees.
  bool are_opened() const;
};

/// A tree of a revision, opened for rays.
struct OpenTree {
  const Instances& instances;
  const RemovedFilter* removed = nullptr;  ///< The instances that have left; null if none.
  std::size_t first = 0;                   ///< The index of its first instance among all.
};

/// The trees of a revision, opened for rays: the instances of all have one numbering, static ones
/// first. A view, valid while the snapshot is.
class OpenTrees {
 public:
  /// Opens the trees. Throws std::bad_alloc.
  explicit OpenTrees(const SceneTrees& trees);

  const std::vector<OpenTree>& all() const { return trees_; }
  const Instances& static_tree() const { return trees_.front().instances; }
  std::span<const OpenTree> dynamic() const { return std::span(trees_).subspan(1); }
  /// The number of instances, removed ones included, which rays never meet.
  std::size_t size() const { return size_; }
  const Instance& operator[](std::size_t index) const {
    const OpenTree& tree = tree_of(index);
    return tree.instances[index - tree.first];
  }
  /// See Instances::world_from_local().
  model::Affine world_from_local(std::size_t index) const {
    return tree_of(index).instances.world_from_local((*this)[index]);
  }

 private:
  const OpenTree& tree_of(std::size_t index) const {
    std::size_t tree = trees_.size() - 1;
    while (index < trees_[tree].first) --tree;
    return trees_[tree];
  }

  std::vector<OpenTree> trees_;
  std::size_t size_ = 0;
};

}  // namespace sightline::scenegraph::instances
