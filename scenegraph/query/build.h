// Builds trees before rays come: all of a revision, or a part of it.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/result.h"
#include "scenegraph/query/or_error.h"
#include "scenegraph/query/shard_cut.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

/// The progress of one build. Numbers only grow, and the totals are set before the first tree is
/// built. Threads: any may read at any time.
struct BuildProgress {
  std::atomic<std::uint64_t> meshes_total{0};  ///< Distinct meshes to build.
  std::atomic<std::uint64_t> meshes_done{0};   ///< Meshes whose trees are complete.
  std::atomic<std::uint64_t> triangles_total{0};
  std::atomic<std::uint64_t> triangles_done{0};  ///< Triangles of the complete meshes.
  std::atomic<std::uint64_t> rays_done{0};       ///< Rays that grow_for_rays() has cast.
  std::atomic<std::uint64_t> cells_expanded{0};
  std::atomic<std::uint64_t> build_us{0};  ///< Time spent on growing trees, summed over threads.

  void add(std::uint64_t cells, double seconds) {
    cells_expanded += cells;
    build_us += static_cast<std::uint64_t>(seconds * 1e6);
  }

  /// The share that is done, from 0 to 1, by triangles; 0 before the totals are set.
  double share() const {
    const std::uint64_t total = triangles_total.load(std::memory_order_relaxed);
    const std::uint64_t done = triangles_done.load(std::memory_order_relaxed);
    return total == 0 ? 0 : static_cast<double>(done) / static_cast<double>(total);
  }
};

/// Builds every tree of the snapshot completely. `progress` must be fresh; null: not reported.
/// Parallel in the caller's arena. Errors: kCancelled, kResourceExhausted.
Result<TraceStats> build_all(const revision::Snapshot& snapshot,
                             const std::atomic<bool>* cancelled = nullptr,
                             BuildProgress* progress = nullptr);

/// Builds the trees of the meshes in the shard, and the scene's own trees, completely. Walks the
/// scene. Only the stats `cells_expanded` and `build_seconds` are set. Parallel in the caller's
/// arena. Errors: kCancelled, kResourceExhausted.
Result<TraceStats> build_shard(const revision::Snapshot& snapshot, const Shard& shard,
                               const std::atomic<bool>* cancelled);

/// The nodes that have a mesh with a finite triangle at or under one of `roots` (if there are
/// none: all), without those at or under one of `excluded`, each once. Errors: kNotFound, naming
/// the id that is no node of this revision.
Result<std::vector<const model::Node*>> mesh_nodes_under(const revision::Snapshot& snapshot,
                                                         std::span<const model::NodeId> roots,
                                                         std::span<const model::NodeId> excluded);

/// The meshes of these nodes, each once.
std::vector<const model::Mesh*> meshes_of(std::span<const model::Node* const> nodes);

/// The number of distinct triangles in finished leaves of the meshes whose trees are begun and not
/// complete. Walks these trees.
std::uint64_t triangles_begun(std::span<const model::Mesh* const> meshes);

/// Builds the trees of these nodes' meshes completely. After a cancel, the built part remains.
/// `progress` must be fresh. Parallel in the caller's arena. Errors: kCancelled,
/// kResourceExhausted.
Status build_mesh_trees(std::span<const model::Node* const> nodes, BuildProgress& progress,
                        const std::atomic<bool>* cancelled);

/// Builds the scene's own trees completely, over all instances. Errors: kCancelled,
/// kResourceExhausted.
Status build_scene_tree(const revision::Snapshot& snapshot, BuildProgress& progress,
                        const std::atomic<bool>* cancelled);

}  // namespace sightline::scenegraph::query
