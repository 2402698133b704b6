// Blocks of rays: a block is one task, on one thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/lazy/lazy_tree.h"
#include "accel/lazy/stall_detector.h"
#include "proto/result.h"
#include "scenegraph/query/caster.h"
#include "scenegraph/query/first_error.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

/// A range of rays.
struct RayBlock {
  std::size_t first = 0, end = 0;
};

/// Cuts rays into blocks and runs answer(RayBlock) for each, in parallel in the caller's arena, in
/// any order. Returns the sum of what the blocks return. Errors: kCancelled, unless the options
/// allow partial answers; those of or_error() for what stops a block.
template <class Answer>
Result<TraceStats> run_blocks(std::size_t rays, std::size_t rays_per_block,
                              const TraceOptions& options, const Answer& answer) {
  const std::size_t blocks = (rays + rays_per_block - 1) / rays_per_block;
  FirstError error;
  TraceStats total = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, blocks, 1), TraceStats{},
      [&](const tbb::blocked_range<std::size_t>& range, TraceStats stats) {
        for (std::size_t b = range.begin();
             b != range.end() && !is_cancelled(options.cancelled) && !error.happened(); ++b) {
          error.run([&] {
            stats += answer(RayBlock{b * rays_per_block, std::min((b + 1) * rays_per_block, rays)});
          });
        }
        return stats;
      },
      [](TraceStats a, const TraceStats& b) { return a += b; });
  if (error.happened()) return error.status().error();
  if (is_cancelled(options.cancelled) && !options.partial)
    return Error{Code::kCancelled, "cancelled while tracing", "CANCELLED"};
  return total;
}

/// Answers packets of suspended rays after all others of their block: answer(RayPacket, waits)
/// returns the rays that are suspended again, because other threads build a cell that
/// they need. In the end they wait, without spinning, for those threads, and then build the cell
/// themselves. Ends before the next packet once `cancelled` is true.
template <class Answer>
void answer_postponed(std::vector<RayPacket>& postponed, const Caster& caster,
                      const std::atomic<bool>* cancelled, const Answer& answer) {
  bool waits = false;
  accel::lazy::StallDetector stall_detector;
  for (std::size_t next = 0, in_vain = 0; !postponed.empty() && !is_cancelled(cancelled);) {
    if (next == postponed.size()) next = 0;
    RayPacket& packet = postponed[next];
    packet.lanes = answer(packet, waits);
    if (packet.lanes == 0) {
      postponed.erase(postponed.begin() + static_cast<std::ptrdiff_t>(next));
      in_vain = 0;
      stall_detector = {};
      continue;
    }
    ++next;
    constexpr std::size_t kTries = 8;
    if (++in_vain < std::min(kTries, postponed.size())) continue;
    in_vain = 0;
    if (!stall_detector.wait(caster.progress())) waits = true;
  }
}

}  // namespace sightline::scenegraph::query
