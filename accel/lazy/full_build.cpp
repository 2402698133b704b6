// Expanding everything, with all threads of the arena.
#include <new>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/grow/fork.h"
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
  std::vector<kdtree::AtomicSlot*> evicted;
  std::uint64_t evicted_references = 0;
};

void collect_deferred(kdtree::AtomicSlot& slot, Deferred& found) {
  const kdtree::Slot now = kdtree::load(slot);
  if (now.is_deferred()) {
    if (now.cell()->evicted) {
      found.evicted.push_back(&slot);
      found.evicted_references += now.cell()->size;
    } else {
      found.slots.push_back(&slot);
    }
  }
  if (!now.is_node()) return;
  for (std::size_t i = 0; i < kdtree::kWidth; ++i) collect_deferred(now.node()->slot(i), found);
}

}  // namespace

void LazyTree::expand_all(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled) {
  if (is_complete()) return;
  const Timed timed(counters);
  while (!is_set(cancelled) && build_left_over(nullptr, counters, cancelled)) continue;
  // A round completes the cells that were deferred when it began, except those that rays claimed.
  for (;;) {
    Deferred deferred;
    const std::uint64_t evicted_before = evicted_.load(std::memory_order_acquire);
    {
      const kdtree::EpochPin pin;
      collect_deferred(tree_.root(), deferred);
    }
    const bool some_wait = evicted_must_wait(deferred.evicted_references);
    if (!some_wait) {
      deferred.slots.insert(deferred.slots.end(), deferred.evicted.begin(), deferred.evicted.end());
    }
    if (deferred.slots.empty() && !some_wait) {
      complete_.store(true, std::memory_order_release);
      // Something may have gone since they were collected.
      if (evicted_.load(std::memory_order_acquire) != evicted_before) complete_.store(false);
    }
    if (deferred.slots.empty() || is_set(cancelled) || !may_build_ahead()) return;
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

/// Whether one thread makes the root's list, which is then no cell's: not if a sample of it, or
/// runs of triangles, may divide it better.
bool LazyTree::may_list_root(kdtree::BuildCounters& counters) const {
  const ReferenceSource::Coarsest coarsest = source_.coarsest(counters);
  return !coarsest.openable && (!rule_->takes_samples() || coarsest.slots < kSampleFrom);
}

/// Divides a long list, and claims a cell that one thread will build.
LazyTree::Step LazyTree::step(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                              const std::atomic<bool>* cancelled, kdtree::DeferredCell*& claimed) {
  const kdtree::EpochPin pin;
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_deferred()) return Step::kBuilt;
  kdtree::DeferredCell& cell = *now.cell();
  if (cell.has_list && cell.weight <= kSerialBelow && budget() != 0 && holds_all(cell)) {
    mark_whole(slot, cell);
    return Step::kAgain;
  }
  const bool is_serial = cell.weight <= kSerialBelow && (cell.has_list || may_list_root(counters));
  if (!cell.whole && !is_serial) {
    const ExpandResult expanded = expand_now(slot, WhenPending::kWait, counters, cancelled);
    return expanded == ExpandResult::kScanList ? Step::kWait : Step::kAgain;
  }
  if (!claim(slot, cell)) return Step::kWait;
  claimed = &cell;
  return Step::kClaimed;
}

/// Returns when the slot and the cells that its divisions made are built. Pinned only for single
/// steps: a pin for longer would keep the lists of all cells alive.
void LazyTree::complete(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                        const std::atomic<bool>* cancelled) {
  StallDetector stall_detector;
  for (;;) {
    if (is_set(cancelled) || !may_build_ahead()) return;
    kdtree::DeferredCell* claimed = nullptr;
    const Step done = step(slot, counters, cancelled, claimed);
    if (done == Step::kBuilt) break;
    if (done == Step::kClaimed) {
      try {  // no other thread retires a claimed cell
        complete_claimed(slot, *claimed, counters, cancelled);
      } catch (const Cancelled&) {  // it is deferred again
      }
      return;
    }
    // A ray's thread has just claimed the cell. It finishes soon, or it is stopped, and then the
    // next round completes the cell.
    if (done == Step::kWait && !stall_detector.wait(0)) return;
  }
  const kdtree::Slot built = kdtree::load(slot);
  if (!built.is_node()) return;
  counters += tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, kdtree::kWidth), kdtree::BuildCounters{},
      [&](const tbb::blocked_range<std::size_t>& range, kdtree::BuildCounters sum) {
        for (std::size_t i = range.begin(); i != range.end(); ++i)
          complete(built.node()->slot(i), sum, cancelled);
        return sum;
      },
      [](kdtree::BuildCounters a, const kdtree::BuildCounters& b) { return a += b; },
      tbb::simple_partitioner());
}

/// Whether a cancelled build has left the lists of its path, which take the room of others.
bool LazyTree::lists_are_left_over() const {
  return budget() != 0 &&
         (tree_.left_over_bytes() > 0 || tree_.deferred_bytes() > most_list_bytes());
}

/// Builds the first such list, from left to right as the cancelled build would have gone on: one,
/// so that a caller who is pinned can renew its pin and free it. False: there is none, or it is
/// being built, or it does not come before that slot.
bool LazyTree::build_left_over(const kdtree::AtomicSlot* before, kdtree::BuildCounters& counters,
                               const std::atomic<bool>* cancelled) {
  if (!lists_are_left_over() || !may_build_ahead()) return false;
  kdtree::AtomicSlot* first = nullptr;
  kdtree::Slot was;
  {
    const kdtree::EpochPin pin;
    Deferred deferred;
    collect_deferred(tree_.root(), deferred);
    const bool some_are_marked = tree_.left_over_bytes() > 0;
    for (kdtree::AtomicSlot* const slot : deferred.slots) {
      if (slot == before) return false;
      was = kdtree::load(*slot);
      if (!was.is_deferred() || was.is_expanding()) continue;
      const kdtree::DeferredCell& cell = *was.cell();
      if (some_are_marked ? cell.left_over : cell.size >= grow::kForkFrom) {
        first = slot;
        break;
      }
    }
  }
  if (first == nullptr) return false;
  complete(*first, counters, cancelled);
  return kdtree::load(*first) != was;
}

}  // namespace sightline::accel::lazy
