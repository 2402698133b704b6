// One revision of a scene: immutable; shares unchanged parts with the revision before it.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "scenegraph/hierarchy/summary_update.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/model/node.h"

namespace sightline::scenegraph::revision {

/// Bounds in world space.
using WorldBounds = model::DoubleBox;

class Snapshot {
 public:
  Snapshot(std::uint64_t revision, hierarchy::Hierarchy hierarchy, instances::SceneTrees trees)
      : revision_(revision), hierarchy_(std::move(hierarchy)), trees_(std::move(trees)) {}
  /// Makes a snapshot with new trees.
  Snapshot(std::uint64_t revision, const hierarchy::Hierarchy& hierarchy);
  Snapshot(const Snapshot&) = delete;
  Snapshot& operator=(const Snapshot&) = delete;

  std::uint64_t revision() const { return revision_; }
  std::size_t node_count() const { return hierarchy_.nodes.size(); }
  /// The node; null if there is none in this revision.
  const model::Node* find(model::NodeId id) const { return hierarchy_.find(id); }
  const hierarchy::NodeMap& nodes() const { return hierarchy_.nodes; }
  const model::ChildList& roots() const { return *hierarchy_.roots; }
  const hierarchy::Hierarchy& hierarchy() const { return hierarchy_; }

  /// The instances in world space and the kd-trees over them. The first call opens them; no thread
  /// waits for another.
  instances::OpenTrees trees() const { return instances::OpenTrees(trees_); }
  const instances::SceneTrees& shared_trees() const { return trees_; }
  /// The distinct meshes, in the order of the first nodes that have them. Walks the scene.
  std::vector<const model::Mesh*> meshes() const;

  /// Whether all trees are complete; set by query::build_all(), which need not look again while no
  /// tree is dropped. `trees_dropped`: Mesh::trees_dropped() before it looked.
  bool is_complete() const {
    return complete_.load(std::memory_order_acquire) == model::Mesh::trees_dropped() + 1;
  }
  void set_complete(std::uint64_t trees_dropped) const {
    complete_.store(trees_dropped + 1, std::memory_order_release);
  }

  /// The bounds of all finite triangles that rays can meet, in world space: over vertices, or over
  /// mesh boxes in very large scenes. Computed at the first call. Throws model::MeshUnreadable.
  const WorldBounds& bounds() const;

 private:
  std::uint64_t revision_ = 0;
  hierarchy::Hierarchy hierarchy_;
  instances::SceneTrees trees_;
  mutable std::once_flag bounds_once_;
  mutable WorldBounds bounds_;
  mutable std::atomic<std::uint64_t> complete_{0};  // 1 + trees dropped before; 0: not complete
};

/// What `scene show` and `stats` report.
struct SceneSummary {
  std::uint64_t revision = 0;
  std::uint64_t nodes = 0;
  std::uint64_t instances = 0;            ///< Nodes that have a mesh, flat ones too.
  std::uint64_t meshes = 0;               ///< Distinct meshes in use.
  std::uint64_t triangles_unique = 0;     ///< Triangles of distinct meshes.
  std::uint64_t triangles_instanced = 0;  ///< Triangles of all instances.
  std::uint64_t triangles_nonfinite = 0;  ///< Unique triangles that are not finite, and never hit.
  std::uint64_t bytes_geometry = 0;       ///< Vertex and index arrays of distinct meshes.
  /// World bounds: min x y z, max x y z. All are NaN where rays can meet no triangle.
  std::array<double, 6> bounds{};
};
SceneSummary summarize(const Snapshot& snapshot);

/// How much of the trees exists. Walks the built part of every distinct mesh's tree. What is in the
/// flat tree (instances::FlatScene) counts as built in its mesh.
struct BuildSummary {
  std::uint64_t instances_total = 0;  ///< Nodes that have a mesh, flat ones too.
  /// Instances whose mesh tree rays have entered or a full build has made.
  std::uint64_t instances_entered = 0;
  std::uint64_t trees_built = 0;  ///< Mesh trees with at least one finished leaf.
  std::uint64_t cells_deferred = 0;
  std::uint64_t cells_expanded = 0;   ///< Inner nodes and leaves.
  std::uint64_t triangles_built = 0;  ///< Distinct triangles in finished leaves.
  std::uint64_t triangles_total = 0;  ///< Triangles of distinct meshes.
  std::uint64_t bytes_geometry = 0;
  std::uint64_t bytes_trees = 0;
  std::uint64_t bytes_lists = 0;  ///< Part of bytes_trees: what is not built in the meshes' trees.
  std::uint64_t bytes_wide_nodes = 0;    ///< Part of bytes_trees: finished subtrees of meshes.
  std::uint64_t static_instances = 0;    ///< Instances in the static tree.
  std::uint64_t dynamic_instances = 0;   ///< Instances in dynamic trees.
  std::uint64_t bytes_static_tree = 0;   ///< Part of bytes_trees: the static tree.
  std::uint64_t bytes_dynamic_tree = 0;  ///< Part of bytes_trees: all dynamic trees.
};
BuildSummary summarize_build(const Snapshot& snapshot);

}  // namespace sightline::scenegraph::revision
