// The way of a ray batch. Start reading here.
#include "scenegraph/trace.h"

#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/tree/epoch.h"
#include "scenegraph/ray_caster.h"

namespace sightline::scenegraph {
namespace {

bool is_cancelled(const std::atomic<bool>* cancelled) {
  return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
}

/// One block of rays: pinned to an epoch, answered in order, by one thread.
TraceStats trace_block(const Instances& instances, std::span<const accel::Ray> rays,
                       std::span<accel::Hit> hits, const TraceOptions& options) {
  const accel::EpochPin pin;
  RayCaster caster(instances, options);
  for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = caster.cast(rays[i]);
  return caster.stats();
}

}  // namespace

TraceStats& TraceStats::operator+=(const TraceStats& o) {
  rays += o.rays;
  hits += o.hits;
  invalid += o.invalid;
  traversal_steps += o.traversal_steps;
  triangle_tests += o.triangle_tests;
  instances_entered += o.instances_entered;
  cells_expanded += o.cells_expanded;
  touches += o.touches;
  touches_prepare += o.touches_prepare;
  build_seconds += o.build_seconds;
  return *this;
}

Result<TraceStats> trace(const Snapshot& snapshot, std::span<const accel::Ray> rays,
                         std::span<accel::Hit> hits, const TraceOptions& options) {
  if (rays.size() != hits.size()) {
    return Error{
        Code::kInvalidArgument,
        std::to_string(rays.size()) + " rays but room for " + std::to_string(hits.size()) + " hits",
        "COUNT_MISMATCH"};
  }
  TraceStats total;
  if (options.growth == Growth::kFull) {
    const Result<TraceStats> built = build_all(snapshot, options.cancelled);
    if (!built) return built.error();
    total += *built;
  }
  const Instances& instances = snapshot.instances();
  total += tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, (rays.size() + kRaysPerBlock - 1) / kRaysPerBlock, 1),
      TraceStats{},
      [&](const tbb::blocked_range<std::size_t>& blocks, TraceStats stats) {
        for (std::size_t b = blocks.begin(); b != blocks.end() && !is_cancelled(options.cancelled);
             ++b) {
          const std::size_t begin = b * kRaysPerBlock;
          const std::size_t count = std::min(kRaysPerBlock, rays.size() - begin);
          stats += trace_block(instances, rays.subspan(begin, count), hits.subspan(begin, count),
                               options);
        }
        return stats;
      },
      [](TraceStats a, const TraceStats& b) { return a += b; });
  if (is_cancelled(options.cancelled))
    return Error{Code::kCancelled, "cancelled while tracing", "CANCELLED"};
  return total;
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
