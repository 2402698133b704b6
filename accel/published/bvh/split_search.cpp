// Object splits first; spatial splits where the children overlap much.
#include "accel/published/bvh/split_search.h"

#include <algorithm>

#include "accel/published/bvh/box_overlap.h"
#include "accel/published/bvh/bvh.h"
#include "accel/published/bvh/plane_search.h"

namespace sightline::accel::published::bvh {
namespace {

double overlap(const CenterLists& node, const ObjectSplit& split) {
  const std::span<const Fragment> list = node.along[split.axis];
  return common_half_area(box_around(list.first(split.left)), box_around(list.subspan(split.left)));
}

}  // namespace

ObjectSplit SplitSearch::between(const CenterLists& node, int depth, SplitScratch& scratch,
                                 kdtree::BuildCounters& counters) const {
  ObjectSplit split;
  if (depth < kHalvingDepth) split = best_object_split(node, scratch.areas, counters);
  return split.found() ? split : middle_split(node);
}

bool SplitSearch::may_split_spatially(const CenterLists& node, int depth) const {
  // The overlap of children lies within the node's box.
  return mesh_ != nullptr && rule_.splits() && depth < kHalvingDepth &&
         half_area(node.box) > least_overlap_;
}

const PlaneSplit* SplitSearch::by_plane(const CenterLists& node, int depth,
                                        const ObjectSplit& object, SplitScratch& scratch,
                                        kdtree::BuildCounters& counters) const {
  if (!may_split_spatially(node, depth)) return nullptr;
  // References that no object split separates are duplicates or nearly so; a plane would only
  // double them.
  if (!(object.sum < half_area(node.box) * static_cast<double>(node.size()))) return nullptr;
  counters.touches += node.size();
  const double common = overlap(node, object);
  if (!(common > least_overlap_) || common < rule_.node_overlap * half_area(node.box))
    return nullptr;
  const SpatialSplit split =
      best_spatial_split(*mesh_, node, rule_.bins, object.sum, scratch.corners, counters);
  if (!split.found()) return nullptr;
  plan_plane_split(*mesh_, node, split, rule_.unsplit, scratch.plane, counters);
  return scratch.plane.reduces(node) ? &scratch.plane : nullptr;
}

}  // namespace sightline::accel::published::bvh
