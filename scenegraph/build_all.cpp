// Building everything before the first ray, and adding up what work has cost.
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "scenegraph/ray_blocks.h"
#include "scenegraph/trace.h"

namespace sightline::scenegraph {

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
  touches_prepare += o.touches_prepare;
  build_seconds += o.build_seconds;
  return *this;
}

Result<TraceStats> build_all(const Snapshot& snapshot, const std::atomic<bool>* cancelled) {
  const Instances& instances = snapshot.instances();
  const std::vector<const Mesh*>& meshes = instances.meshes();
  accel::BuildCounters built = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, meshes.size(), 1), accel::BuildCounters{},
      [&](const tbb::blocked_range<std::size_t>& range, accel::BuildCounters sum) {
        for (std::size_t i = range.begin(); i != range.end(); ++i)
          meshes[i]->tree().expand_all(sum, cancelled);
        return sum;
      },
      [](accel::BuildCounters a, const accel::BuildCounters& b) { return a += b; });
  instances.tree().expand_all(built, cancelled);
  if (is_cancelled(cancelled))
    return Error{Code::kCancelled, "cancelled while building", "CANCELLED"};
  for (const Instance& instance : instances.list())
    instance.entered->store(true, std::memory_order_relaxed);
  TraceStats stats;
  stats.cells_expanded = built.cells_expanded;
  stats.touches = built.touches;
  stats.touches_prepare = built.touches_prepare;
  stats.build_seconds = built.seconds;
  return stats;
}

}  // namespace sightline::scenegraph
