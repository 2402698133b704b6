// Rays in blocks: a block is one task, on one thread, pinned to one epoch.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/tree/epoch.h"
#include "scenegraph/ray_caster.h"
#include "scenegraph/trace.h"

namespace sightline::scenegraph {

inline bool is_cancelled(const std::atomic<bool>* cancelled) {
  return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
}

/// A range of rays.
struct RayBlock {
  std::size_t first = 0, end = 0;
};

/// Cuts rays into blocks and has each answered: answer(caster, block), in parallel, in any order.
/// Errors: kCancelled.
template <class Answer>
Result<TraceStats> answer_in_blocks(const Snapshot& snapshot, std::size_t rays,
                                    std::size_t rays_per_block, const TraceOptions& options,
                                    const Answer& answer) {
  TraceStats total;
  if (options.growth == Growth::kFull) {
    const Result<TraceStats> built = build_all(snapshot, options.cancelled);
    if (!built) return built.error();
    total += *built;
  }
  const Instances& instances = snapshot.instances();
  total += tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, (rays + rays_per_block - 1) / rays_per_block, 1),
      TraceStats{},
      [&](const tbb::blocked_range<std::size_t>& blocks, TraceStats stats) {
        for (std::size_t b = blocks.begin(); b != blocks.end() && !is_cancelled(options.cancelled);
             ++b) {
          const accel::EpochPin pin;
          RayCaster caster(instances, options);
          answer(caster, RayBlock{b * rays_per_block, std::min((b + 1) * rays_per_block, rays)});
          stats += caster.stats();
        }
        return stats;
      },
      [](TraceStats a, const TraceStats& b) { return a += b; });
  if (is_cancelled(options.cancelled))
    return Error{Code::kCancelled, "cancelled while tracing", "CANCELLED"};
  return total;
}

}  // namespace sightline::scenegraph
