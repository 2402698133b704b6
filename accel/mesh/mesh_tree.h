// The tree over a mesh's triangles, built by the rays that enter it. Queries: the nearest hit, any
// hit, all hits.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/kdtree/walk_counters.h"
#include "accel/lazy/cell_query.h"
#include "accel/mesh/mesh_stats.h"
#include "accel/mesh/tree_builder.h"
#include "accel/mesh/whole_tree.h"
#include "accel/wide/packet.h"

namespace sightline::accel::mesh {

/// A kd-tree that grows cell by cell, or, for comparisons, a tree that is built whole.
///
/// Threads: all members, from any thread pinned to an epoch.
class MeshTree {
 public:
  /// The view's arrays must outlive the tree; `alive` keeps them alive for tasks that outlive it
  /// (see ReferenceSource::alive). Reads no face before the first ray.
  MeshTree(geometry::MeshView mesh, const MeshStats& stats, const TreeBuilder& builder,
           References references = References::kRuns, std::shared_ptr<const void> alive = nullptr);

  /// Finds hits of the rays in `lanes`, which are in the mesh's frame: by Packet::goal the nearest,
  /// whether there are any, or every one. Requires Packet::best, and the question (Packet::goal to
  /// Packet::sinks).
  void query(wide::Packet& packet, std::uint32_t lanes, lazy::CellQuery& cells,
             kdtree::WalkCounters& walked, kdtree::BuildCounters& built);

  /// Expands every cell, or ends soon after `cancelled` is true. A whole tree whose build has begun
  /// is completed.
  void expand_all(kdtree::BuildCounters& built, const std::atomic<bool>* cancelled = nullptr);
  /// Whether expand_all() has nothing left to do.
  bool is_complete() const;

  bool untouched() const;
  std::uint64_t bytes() const;
  kdtree::TreeMetrics metrics() const;
  kdtree::GrowthMetrics growth() const;

  /// The kd-tree and the whole tree, one of which is null.
  const kdtree::KdTree* kd() const;
  const WholeTree* whole() const;
  /// The kd-tree; null for a whole tree.
  lazy::LazyTree* lazy_tree() { return std::get_if<lazy::LazyTree>(&tree_); }

 private:
  using Tree = std::variant<lazy::LazyTree, std::unique_ptr<WholeTree>>;
  static Tree make(const geometry::MeshView& mesh, const geometry::MeshView* own,
                   const MeshStats& stats, const TreeBuilder& builder, References references,
                   std::shared_ptr<const void> alive);
  void query_whole_for_points(wide::Packet& packet, std::uint32_t lanes,
                              const lazy::CellQuery& cells, kdtree::WalkCounters& walked);
  void query_whole(WholeTree& tree, FaceTest& test, const lazy::CellQuery& cells,
                   kdtree::WalkCounters& walked, kdtree::BuildCounters& built);

  geometry::MeshView mesh_;
  geometry::Aabb bounds_;  ///< The box of all references.
  std::uint64_t finite_triangles_ = 0;
  Tree tree_;
};

}  // namespace sightline::accel::mesh
