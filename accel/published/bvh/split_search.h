// The best split of a node: an object split or a spatial split.
#pragma once

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/center_lists.h"
#include "accel/published/bvh/object_split.h"
#include "accel/published/bvh/plane_split.h"
#include "accel/published/bvh/spatial_bins.h"
#include "accel/published/bvh/spatial_split.h"

namespace sightline::accel::published::bvh {

/// Scratch memory that a task keeps from node to node.
struct SplitScratch {
  FragmentStack lists;
  SweepAreas areas;
  ListCorners corners;
  PlaneSplit plane;
};

/// Threads: any, each with its own scratch. Long lists are searched in parallel.
class SplitSearch {
 public:
  /// If `mesh` is null, there are no spatial splits.
  SplitSearch(const geometry::MeshView* mesh, const SpatialRule& rule, const geometry::Aabb& root)
      : mesh_(mesh), rule_(rule), least_overlap_(rule.alpha * half_area(root)) {}

  /// Returns the best object split; halves the list if nothing can be separated or the node is at
  /// kHalvingDepth. The node has at least two references.
  ObjectSplit between(const CenterLists& node, int depth, SplitScratch& scratch,
                      kdtree::BuildCounters& counters) const;

  /// Whether spatial splits may be tried in the node or below it.
  bool may_split_spatially(const CenterLists& node, int depth) const;

  /// Returns the best spatial split, if the children of `object` overlap enough for the rule (Stich
  /// et al. 2009, section 4.5); null if it costs more or reduces nothing, or if object splits
  /// separate nothing. The plan is in the scratch.
  ///
  /// Touches: a pass for the overlap, best_spatial_split, plan_plane_split.
  const PlaneSplit* by_plane(const CenterLists& node, int depth, const ObjectSplit& object,
                             SplitScratch& scratch, kdtree::BuildCounters& counters) const;

 private:
  const geometry::MeshView* mesh_;
  SpatialRule rule_;
  double least_overlap_;
};

}  // namespace sightline::accel::published::bvh
