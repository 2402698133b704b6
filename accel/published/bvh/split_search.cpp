// Object splits first, planes where they leave much overlap.
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
  // Children overlap in no more than the node.
  return mesh_ != nullptr && rule_.splits() && depth < kHalvingDepth &&
         half_area(node.box) > least_overlap_;
}

const PlaneSplit* SplitSearch::by_plane(const CenterLists& node, int depth,
                                        const ObjectSplit& object, SplitScratch& scratch,
                                        kdtree::BuildCounters& counters) const {
  if (!may_split_spatially(node, depth)) return nullptr;
  // What no order separates are duplicates, or as good as that: planes would only double them.
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
