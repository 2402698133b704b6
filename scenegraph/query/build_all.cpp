// Building everything before the first ray, and adding up what work has cost.
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "scenegraph/query/ray_blocks.h"
#include "scenegraph/trace.h"

namespace sightline::scenegraph {
namespace {

void announce(query::BuildProgress& progress, const std::vector<const model::Mesh*>& meshes) {
  std::uint64_t triangles = 0;
  for (const model::Mesh* mesh : meshes) triangles += mesh->triangles();
  progress.meshes_total.store(meshes.size(), std::memory_order_relaxed);
  progress.triangles_total.store(triangles, std::memory_order_relaxed);
}

void count_done(query::BuildProgress& progress, const model::Mesh& mesh) {
  progress.meshes_done.fetch_add(1, std::memory_order_relaxed);
  progress.triangles_done.fetch_add(mesh.triangles(), std::memory_order_relaxed);
}

}  // namespace

TraceStats& TraceStats::operator+=(const TraceStats& o) {
  rays += o.rays;
  hits += o.hits;
  invalid += o.invalid;
  hits_found += o.hits_found;
  cut_off += o.cut_off;
  traversal_steps += o.traversal_steps;
  triangle_tests += o.triangle_tests;
  instances_entered += o.instances_entered;
  cells_expanded += o.cells_expanded;
  touches += o.touches;
  dynamic_touches += o.dynamic_touches;
  touches_prepare += o.touches_prepare;
  build_seconds += o.build_seconds;
  return *this;
}

Result<TraceStats> build_all(const revision::Snapshot& snapshot, const std::atomic<bool>* cancelled,
                             query::BuildProgress* progress) {
  const std::vector<const model::Mesh*> meshes = snapshot.meshes();
  if (progress != nullptr) announce(*progress, meshes);
  accel::kdtree::BuildCounters built = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, meshes.size(), 1), accel::kdtree::BuildCounters{},
      [&](const tbb::blocked_range<std::size_t>& range, accel::kdtree::BuildCounters sum) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          meshes[i]->tree().expand_all(sum, cancelled);
          if (progress != nullptr && !query::is_cancelled(cancelled))
            count_done(*progress, *meshes[i]);
        }
        return sum;
      },
      [](accel::kdtree::BuildCounters a, const accel::kdtree::BuildCounters& b) { return a += b; });
  const instances::TwoTrees trees = snapshot.trees();
  trees.still.tree().expand_all(built, cancelled);
  accel::kdtree::BuildCounters moving;
  trees.moving.tree().expand_all(moving, cancelled);
  built += moving;
  if (query::is_cancelled(cancelled))
    return Error{Code::kCancelled, "cancelled while building", "CANCELLED"};
  snapshot.nodes().for_each([](model::NodeId, const std::shared_ptr<const model::Node>& node) {
    if (hierarchy::is_instance(*node)) node->entered->store(true, std::memory_order_relaxed);
  });
  TraceStats stats;
  stats.cells_expanded = built.cells_expanded;
  stats.touches = built.touches;
  stats.dynamic_touches = moving.touches + moving.touches_prepare;
  stats.touches_prepare = built.touches_prepare;
  stats.build_seconds = built.seconds;
  return stats;
}

}  // namespace sightline::scenegraph
