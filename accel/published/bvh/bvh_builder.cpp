// Makes references of faces, splits them if the method does, and builds a hierarchy over them.
#include "accel/published/bvh/bvh_builder.h"

#include <vector>

#include "accel/mesh/face_boxes.h"
#include "accel/published/bvh/binned_growth.h"
#include "accel/published/bvh/center_bins.h"
#include "accel/published/bvh/edge_split.h"
#include "accel/published/bvh/sweep_growth.h"
#include "accel/split/out_of_range.h"

namespace sightline::accel::published::bvh {

std::optional<std::string> BvhBuilder::check() const {
  if (auto e = split::out_of_range("leaf_size", leaf.leaf_size, 1u, 64u)) return e;
  if (auto e = split::out_of_range("cost_traverse", leaf.traverse, 0.0, 1e6)) return e;
  if (auto e = split::out_of_range("cost_intersect", leaf.intersect, 1e-6, 1e6)) return e;
  if (auto e = split::out_of_range("bins", bins, 2u, CenterBins::kMaxBins)) return e;
  if (auto e = pre_split.check()) return e;
  return spatial.check();
}

Bvh BvhBuilder::build(const geometry::MeshView& mesh, kdtree::BuildCounters& counters) const {
  std::vector<kdtree::Reference> refs(mesh.faces.size());
  refs.resize(mesh::face_references(mesh, 0, mesh.faces.size(), refs.data()));
  counters.touches_prepare += mesh.faces.size();
  if (refs.empty()) return {};
  if (method == BvhMethod::kEarly) refs = split_early(mesh, std::move(refs), pre_split, counters);
  if (method == BvhMethod::kEdgeVolume)
    refs = split_edges(mesh, std::move(refs), pre_split, counters);
  if (method == BvhMethod::kBinned) {
    BvhGrowth growth(refs.size());
    return growth.finish(grow_binned(refs, leaf, bins, growth, counters));
  }
  const SpatialRule rule = method == BvhMethod::kSpatial ? spatial : SpatialRule{.alpha = 1};
  BvhGrowth growth(sweep_capacity(refs.size(), rule), repeats);
  return growth.finish(grow_by_sweep(&mesh, std::move(refs), leaf, rule, growth, counters));
}

}  // namespace sightline::accel::published::bvh
