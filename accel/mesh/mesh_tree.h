// The tree over a mesh's triangles, built by the rays that enter it. Queries: the nearest hit, any
// hit, all hits.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>

#include "accel/geometry/facing.h"
#include "accel/geometry/ray.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/traverse.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/lazy/walk_lazily.h"
#include "accel/mesh/mesh_stats.h"
#include "accel/mesh/tree_builder.h"
#include "accel/mesh/unique_hits.h"
#include "accel/mesh/whole_tree.h"
#include "accel/wide/pencil.h"

namespace sightline::accel::mesh {

using lazy::OnDeferred;

/// Where the hits of a ray go that asks for more than one; both null: it does not.
struct HitSinks {
  UniqueHits<ListedHit>* list = nullptr;
  UniqueHits<std::uint32_t>* primitives = nullptr;

  bool collects() const { return list != nullptr || primitives != nullptr; }
};

/// A query: the ray in one mesh's frame, and the hits found so far. t is in units of the world
/// ray's direction.
///
/// Nearest or any hit: a hit is accepted if (t, node, primitive) is less than (best_t, best_node,
/// best_primitive). With `list` or `primitives`: every hit is added there, once for each cell that
/// it is found in; best_t is then the t beyond which hits are not needed.
struct MeshQuery : lazy::LazyQuery, HitSinks {
  geometry::LocalRay ray;
  double tmin = 0, tmax = geometry::kInfinity;
  geometry::Culling culling = geometry::Culling::kNone;  ///< By the winding in the mesh's frame.
  bool any = false;                                      ///< Stop at the first hit found.
  std::uint64_t node = 0;
  std::uint32_t instance = 0;  ///< The caller's number for the node.
  double best_t = std::numeric_limits<double>::max();
  std::uint64_t best_node = ~std::uint64_t{0};
  std::uint32_t best_primitive = 0;
  std::uint32_t best_instance = 0;
  bool found = false;

  /// Nothing can change the answer any more, or the query is suspended or cancelled.
  bool is_done() const { return suspended || (any && found) || is_cancelled(); }
};

/// What the queries of a packet's rays share, and what they cost.
struct PacketQuery {
  lazy::LazyQuery& lazy;
  std::uint32_t& saw_deferred;  ///< Gets a bit for each ray that met a cell which was skipped or
                                ///< searched.
  kdtree::WalkCounters& walked;
  kdtree::BuildCounters& built;
  std::span<const HitSinks> sinks = {};  ///< By ray; empty: for the nearest or any hit.
};

/// A kd-tree that grows cell by cell, or, for comparisons, a tree that is built whole.
///
/// Threads: all members, from any thread pinned to an epoch.
class MeshTree {
 public:
  /// The view's arrays must outlive the tree; `alive` keeps them alive for tasks that outlive it
  /// (see ReferenceSource::alive). Reads no face before the first ray.
  MeshTree(geometry::MeshView mesh, const MeshStats& stats, const TreeBuilder& builder,
           References references = References::kRuns, std::shared_ptr<const void> alive = nullptr);

  /// Finds hits and updates the query.
  void query(MeshQuery& query, kdtree::WalkCounters& walked, kdtree::BuildCounters& built);

  /// As query() for those rays of the packet.
  void query(wide::Packet& packet, std::uint32_t lanes, const PacketQuery& query);

  /// As query() for any or the nearest hits of a pencil in a finished tree: wide::walk_pencil().
  wide::PencilLanes query_pencil(std::span<wide::Packet> packets, const wide::PencilLanes& lanes,
                                 kdtree::WalkCounters& walked);

  /// Expands every cell, or until `cancelled`. Building a whole tree that has begun is not
  /// cancelled.
  void expand_all(kdtree::BuildCounters& built, const std::atomic<bool>* cancelled = nullptr);
  /// Whether expand_all() has nothing left to do.
  bool is_complete() const;

  bool untouched() const;
  std::uint64_t bytes() const;
  kdtree::TreeMetrics metrics() const;
  kdtree::GrowthMetrics growth() const;

  /// The kd-tree or the whole tree; the other is null.
  const kdtree::KdTree* kd() const;
  const WholeTree* whole() const;
  /// The kd-tree; null for a whole tree.
  lazy::LazyTree* lazy_tree() { return std::get_if<lazy::LazyTree>(&tree_); }

 private:
  using Tree = std::variant<lazy::LazyTree, std::unique_ptr<WholeTree>>;
  static Tree make(const geometry::MeshView& mesh, const geometry::MeshView* own,
                   const MeshStats& stats, const TreeBuilder& builder, References references,
                   std::shared_ptr<const void> alive);
  void query_whole(WholeTree& tree, LeafTest test, kdtree::BuildCounters& built);

  geometry::MeshView mesh_;
  geometry::Aabb bounds_;  ///< Contains all references.
  std::uint64_t finite_triangles_ = 0;
  Tree tree_;
};

}  // namespace sightline::accel::mesh
