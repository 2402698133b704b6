// The tree over a mesh's triangles: grown by the rays that enter it, asked for the nearest hit, for
// any, or for every one.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <variant>

#include "accel/geometry/facing.h"
#include "accel/geometry/ray.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/kdtree/tree_ray.h"
#include "accel/lazy/walk_lazily.h"
#include "accel/mesh/mesh_stats.h"
#include "accel/mesh/unique_hits.h"
#include "accel/mesh/whole_tree.h"
#include "accel/split/scan_split.h"

namespace sightline::accel::mesh {

/// What a mesh's tree is made by.
struct TreeBuilder {
  split::SplitRule rule = split::default_rule();
  /// If set, the tree is built whole by it, and `rule` is not used.
  std::shared_ptr<const WholeTreeMaker> whole = nullptr;
};

/// What a mesh's tree begins with.
enum class References : std::uint8_t {
  kSoup,  ///< Every triangle on its own, as in the paper.
  kRuns,  ///< Runs of consecutive triangles, where those are compact; opened where rays look.
};

using lazy::AtUnbuilt;

/// The ray as it stands in one mesh's frame, and what has been found so far. t counts in the world
/// ray's direction.
///
/// The nearest hit or any: a hit is taken if (t, node, primitive) is less than (best_t, best_node,
/// best_primitive). With `list` or `primitives`: every hit is added there, once for each cell it is
/// met in; best_t is then only the t beyond which none is wanted.
struct MeshQuery : lazy::LazyQuery {
  geometry::LocalRay ray;
  double tmin = 0, tmax = geometry::kInfinity;
  geometry::Culling culling = geometry::Culling::kNone;  ///< By the winding in the mesh's frame.
  bool any = false;                                      ///< Stop at the first hit found.
  std::uint64_t node = 0;
  std::uint32_t instance = 0;  ///< The caller's; goes with the node.
  double best_t = std::numeric_limits<double>::max();
  std::uint64_t best_node = ~std::uint64_t{0};
  std::uint32_t best_primitive = 0;
  std::uint32_t best_instance = 0;
  bool found = false;
  Distinct<ListedHit>* list = nullptr;
  Distinct<std::uint32_t>* primitives = nullptr;

  bool collects() const { return list != nullptr || primitives != nullptr; }
};

/// A kd-tree that grows cell by cell. For comparisons a tree that is built whole can stand in.
///
/// Threads: all members, from any thread pinned to an epoch.
class MeshTree {
 public:
  /// The view's arrays must outlive the tree; `alive` keeps them for work that is left behind when
  /// it is gone (see ReferenceSource::alive). Faces are not looked at before the first ray.
  MeshTree(geometry::MeshView mesh, const MeshSurvey& survey, const TreeBuilder& builder,
           References references = References::kRuns, std::shared_ptr<const void> alive = nullptr);

  /// Looks for hits and updates the query.
  void query(MeshQuery& query, kdtree::WalkCounters& walked, kdtree::BuildCounters& built);

  /// "Expand everything." A hierarchy that has begun is not cancelled.
  void expand_all(kdtree::BuildCounters& built, const std::atomic<bool>* cancelled = nullptr);

  bool untouched() const;
  std::uint64_t bytes() const;
  kdtree::TreeMetrics metrics() const;
  kdtree::GrowthMetrics growth() const;

  /// The one that there is; the other is null.
  const kdtree::KdTree* kd() const;
  const WholeTree* whole() const;

 private:
  using Tree = std::variant<lazy::LazyTree, std::unique_ptr<WholeTree>>;
  static Tree make(const geometry::MeshView& mesh, const geometry::MeshView* own,
                   const MeshSurvey& survey, const TreeBuilder& builder, References references,
                   std::shared_ptr<const void> alive);
  void query_whole(WholeTree& tree, LeafTest test, kdtree::BuildCounters& built);

  geometry::MeshView mesh_;
  geometry::Aabb bounds_;  ///< Holds all references.
  std::uint64_t finite_triangles_ = 0;
  Tree tree_;
};

}  // namespace sightline::accel::mesh
