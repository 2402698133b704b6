// Building trees before rays come: those of a part of the scene, or what given rays will touch.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/query/build_progress.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/trace.h"

namespace sightline::scenegraph::query {

/// How far a prefetch has come. Numbers only grow. Threads: any, at any time.
struct PrefetchProgress {
  BuildProgress trees;  ///< Of build_mesh_trees().
  std::atomic<std::uint64_t> rays_done{0};
  std::atomic<std::uint64_t> cells_expanded{0};
  std::atomic<std::uint64_t> build_us{0};  ///< Growing trees, summed over threads.

  /// Of BuildProgress::triangles_total: those of the trees that are done, and about as many as are
  /// built in those that are under way.
  std::uint64_t triangles_reached();

 private:
  friend class TreeInWork;
  std::mutex mutex_;
  std::vector<const model::Mesh*> under_way_;
  std::uint64_t told_ = 0;
};

/// The nodes that carry a mesh with a finite triangle at or under one of `roots` (if there are
/// none: all), less what is at or under one of `excluded`, each once. Errors: kNotFound, naming the
/// id that is no node of this revision.
Result<std::vector<const model::Node*>> mesh_nodes_under(const revision::Snapshot& snapshot,
                                                         std::span<const model::NodeId> roots,
                                                         std::span<const model::NodeId> excluded);

/// The meshes of these nodes, each once.
std::vector<const model::Mesh*> meshes_of(std::span<const model::Node* const> nodes);

/// Builds the trees of these nodes' meshes to their ends. What is built when it is cancelled stays.
/// `progress` must be fresh. Parallel in the caller's arena. Errors: kCancelled.
Status build_mesh_trees(std::span<const model::Node* const> nodes, PrefetchProgress& progress,
                        const std::atomic<bool>* cancelled);

/// The same for the scene's own tree, over all its instances.
Status build_scene_tree(const revision::Snapshot& snapshot, PrefetchProgress& progress,
                        const std::atomic<bool>* cancelled);

/// Grows what a cast of these rays would, and keeps no hit. `options` are those of the cast, of any
/// kind. Parallel in the caller's arena. Errors: kCancelled.
Status grow_for_rays(const revision::Snapshot& snapshot, std::span<const accel::geometry::Ray> rays,
                     TraceOptions options, PrefetchProgress& progress);

}  // namespace sightline::scenegraph::query
