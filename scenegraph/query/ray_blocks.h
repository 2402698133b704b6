// Rays in blocks: a block is one task, on one thread, pinned to one epoch.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <deque>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/stall_detector.h"
#include "scenegraph/query/build.h"
#include "scenegraph/query/ray_caster.h"

namespace sightline::scenegraph::query {

inline bool is_cancelled(const std::atomic<bool>* cancelled) {
  return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
}

/// A range of rays.
struct RayBlock {
  std::size_t first = 0, end = 0;
};

/// Answers the rays of a block: answer(ray, WhenPending) returns false if the ray is suspended
/// because other threads build a cell that it needs. Suspended rays are postponed until all others
/// are answered. Then they wait, without spinning, for those threads, and in the end build the cell
/// themselves.
template <class Answer>
void answer_block(const RayCaster& caster, const RayBlock& block, const Answer& answer) {
  std::deque<std::size_t> postponed;
  for (std::size_t ray = block.first; ray < block.end; ++ray) {
    if (!answer(ray, accel::lazy::WhenPending::kReturn)) postponed.push_back(ray);
  }
  accel::lazy::WhenPending when_pending = accel::lazy::WhenPending::kReturn;
  accel::lazy::StallDetector stall_detector;
  for (std::size_t in_vain = 0; !postponed.empty();) {
    const std::size_t ray = postponed.front();
    postponed.pop_front();
    if (answer(ray, when_pending)) {
      in_vain = 0;
      stall_detector = {};
      continue;
    }
    postponed.push_back(ray);
    constexpr std::size_t kTries = 8;
    if (++in_vain < std::min(kTries, postponed.size())) continue;
    in_vain = 0;
    if (!stall_detector.wait(caster.progress())) when_pending = accel::lazy::WhenPending::kWait;
  }
}

/// Cuts rays into blocks and has each answered: answer(caster, block), in parallel, in any order.
/// Errors: kCancelled.
template <class Answer>
Result<TraceStats> answer_in_blocks(const revision::Snapshot& snapshot, std::size_t rays,
                                    std::size_t rays_per_block, const TraceOptions& options,
                                    const Answer& answer) {
  TraceStats total;
  if (options.growth == Growth::kFull) {
    const Result<TraceStats> built = build_all(snapshot, options.cancelled, options.progress);
    if (!built) return built.error();
    total += *built;
  }
  const instances::OpenTrees trees = snapshot.trees();
  total += tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, (rays + rays_per_block - 1) / rays_per_block, 1),
      TraceStats{},
      [&](const tbb::blocked_range<std::size_t>& blocks, TraceStats stats) {
        for (std::size_t b = blocks.begin(); b != blocks.end() && !is_cancelled(options.cancelled);
             ++b) {
          const accel::kdtree::EpochPin pin;
          RayCaster caster(trees, options);
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

}  // namespace sightline::scenegraph::query
