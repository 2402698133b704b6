// Expanding everything, with all threads of the arena.
#include <new>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/lazy/stall_detector.h"
#include "accel/lazy/timed.h"

namespace sightline::accel::lazy {
namespace {

/// In full builds all threads share a cell above this weight and divide it; any other cell's
/// subtree is built by one thread.
constexpr std::uint64_t kSerialBelow = 65536;

struct Deferred {
  std::vector<kdtree::AtomicSlot*> slots;  ///< All with something to expand.
  bool some_failed = false;                ///< There are others, for which there was no memory.
};

void collect_deferred(const kdtree::KdTree& tree, kdtree::AtomicSlot& slot, Deferred& found) {
  const kdtree::Slot now = kdtree::load(slot);
  if (now.is_deferred()) {
    if (now.cell()->failed.load(std::memory_order_relaxed)) {
      found.some_failed = true;
    } else {
      found.slots.push_back(&slot);
    }
  }
  if (!now.is_binary()) return;
  kdtree::AtomicSlot* children = tree.children(now);
  collect_deferred(tree, children[0], found);
  collect_deferred(tree, children[1], found);
}

}  // namespace

void LazyTree::expand_all(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled) {
  if (is_complete()) return;
  const kdtree::EpochPin pin;
  const Timed timed(counters);
  // A round completes the cells that were deferred when it began, except those that rays claimed.
  for (;;) {
    Deferred deferred;
    collect_deferred(tree_, tree_.root(), deferred);
    if (deferred.slots.empty() && !deferred.some_failed)
      complete_.store(true, std::memory_order_release);
    if (deferred.slots.empty() ||
        (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)))
      return;
    counters += tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, deferred.slots.size()), kdtree::BuildCounters{},
        [&](const tbb::blocked_range<std::size_t>& range, kdtree::BuildCounters sum) {
          for (std::size_t i = range.begin(); i != range.end(); ++i)
            complete(*deferred.slots[i], sum, cancelled);
          return sum;
        },
        [](kdtree::BuildCounters a, const kdtree::BuildCounters& b) { return a += b; });
  }
}

/// Returns when the slot and the cells that its divisions made are built.
void LazyTree::complete(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                        const std::atomic<bool>* cancelled) {
  const kdtree::EpochPin pin;
  StallDetector stall_detector;
  for (kdtree::Slot now = kdtree::load(slot); now.is_deferred(); now = kdtree::load(slot)) {
    kdtree::DeferredCell& cell = *now.cell();
    if (cell.failed.load(std::memory_order_relaxed)) return;
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) return;
    if (!cell.has_list || cell.weight > kSerialBelow) {
      if (expand_now(slot, WhenPending::kWait, counters, cancelled) != ExpandResult::kScanList)
        continue;
    } else if (claim(slot, cell)) {
      return complete_cell(slot, cell, counters, cancelled);
    }
    // A ray's thread has just claimed the cell. It finishes soon, or it is stopped, and then the
    // next round completes the cell.
    if (!stall_detector.wait(0)) return;
  }
  const kdtree::Slot built = kdtree::load(slot);
  if (!built.is_binary()) return;
  kdtree::AtomicSlot* children = tree_.children(built);
  kdtree::BuildCounters right;
  tbb::parallel_invoke([&] { complete(children[0], counters, cancelled); },
                       [&] { complete(children[1], right, cancelled); });
  counters += right;
}

void LazyTree::complete_cell(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                             kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled) {
  try {
    publish(slot, cell, finish(cell, counters, cancelled), counters);
  } catch (const std::bad_alloc&) {
    release_claim(slot, cell);
  }
}

}  // namespace sightline::accel::lazy
