// How a node is best split: between references, or through them.
#pragma once

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/center_lists.h"
#include "accel/published/bvh/fragment_corners.h"
#include "accel/published/bvh/object_split.h"
#include "accel/published/bvh/plane_split.h"
#include "accel/published/bvh/spatial_split.h"

namespace sightline::accel::published::bvh {

/// What a task keeps from node to node.
struct SplitScratch {
  FragmentStack lists;
  SweepAreas areas;
  ListCorners corners;
  PlaneSplit plane;
};

/// Threads: any, each with its own scratch. In long lists it looks on several at once.
class SplitSearch {
 public:
  /// `mesh` null: no spatial splits.
  SplitSearch(const geometry::MeshView* mesh, const SpatialRule& rule, const geometry::Aabb& root)
      : mesh_(mesh), rule_(rule), least_overlap_(rule.alpha * half_area(root)) {}

  /// The best split between references, or a middle one where nothing can be separated or the node
  /// is at kHalvingDepth. At least two references.
  ObjectSplit between(const CenterLists& node, int depth, SplitScratch& scratch,
                      kdtree::BuildCounters& counters) const;

  /// Whether spatial splits may be tried in the node or below.
  bool may_split_spatially(const CenterLists& node, int depth) const;

  /// The best split by a plane, where the children of `object` overlap by so much that the rule
  /// has it tried (Stich et al. 2009, section 4.5); nothing if it does not cost less or
  /// does not reduce, nor where object splits separate nothing. It is planned in the scratch.
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
