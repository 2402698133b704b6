// Expanding everything, with all threads of the arena.
#include "accel/lazy/full_build.h"

#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/grow/fork.h"
#include "accel/kdtree/epoch.h"
#include "accel/lazy/cell_reader.h"
#include "accel/lazy/demand_costs.h"
#include "accel/lazy/expansion.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/lazy/split_tree.h"
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

/// Calls complete_one(item, counters) for every item, in parallel.
template <class CompleteOne>
void complete_each(std::size_t items, kdtree::BuildCounters& counters,
                   const CompleteOne& complete_one) {
  counters += tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, items), kdtree::BuildCounters{},
      [&](const tbb::blocked_range<std::size_t>& range, kdtree::BuildCounters sum) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) complete_one(i, sum);
        return sum;
      },
      [](kdtree::BuildCounters a, const kdtree::BuildCounters& b) { return a += b; });
}

/// Whether one thread makes the references that the cell is built of: not if a sample of the root,
/// or runs of triangles, may divide it better.
bool is_serial(const TreeContext& context, const kdtree::DeferredCell& cell,
               kdtree::BuildCounters& counters) {
  if (cell.weight > kSerialBelow || cell.has_list) return cell.weight <= kSerialBelow;
  const CellReader root(context.source, cell, counters);
  return !root.openable() && (!context.rule->takes_samples() || root.size() < kSampleFrom);
}

/// Divides a long list, or claims a cell that one thread will build. Returns whether the slot has
/// changed.
bool take_step(TreeContext& context, kdtree::DeferredCell& cell, Expansion& expansion,
               kdtree::BuildCounters& counters) {
  if (cell.has_list && cell.weight <= kSerialBelow && context.budget() != 0 &&
      context.holds_all(cell)) {
    expansion.mark_whole(cell);
    return true;
  }
  if (cell.whole || is_serial(context, cell, counters)) return expansion.claim(cell);
  return expansion.expand(/*waits=*/true) != AtCell::kSearch;
}

}  // namespace

void complete(TreeContext& context, kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
              const std::atomic<bool>* cancelled) {
  StallDetector stall_detector;
  for (;;) {
    if (is_set(cancelled) || !context.may_build_ahead()) return;
    Expansion expansion(context, slot, counters, cancelled, kSerialBelow);
    bool has_changed = false;
    {
      const kdtree::EpochPin pin;  // for one step: a longer one would keep the lists of all cells
      const kdtree::Slot now = kdtree::load(slot);
      if (!now.is_deferred()) break;
      has_changed = take_step(context, *now.cell(), expansion, counters);
    }
    if (expansion.build_claimed()) return;
    // A ray's thread has just claimed the cell. It finishes soon, or it is stopped, and then the
    // next round completes the cell.
    if (!has_changed && !stall_detector.wait(0)) return;
  }
  const kdtree::Slot built = kdtree::load(slot);
  if (!built.is_node()) return;
  complete_each(kdtree::kWidth, counters, [&](std::size_t i, kdtree::BuildCounters& sum) {
    complete(context, built.node()->slot(i), sum, cancelled);
  });
}

bool lists_are_left_over(const TreeContext& context) {
  return context.budget() != 0 && (context.tree.left_over_bytes() > 0 ||
                                   context.tree.deferred_bytes() > most_list_bytes(context));
}

bool build_left_over(TreeContext& context, const kdtree::AtomicSlot* before,
                     kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled) {
  if (!lists_are_left_over(context) || !context.may_build_ahead()) return false;
  kdtree::AtomicSlot* first = nullptr;
  kdtree::Slot was;
  {
    const kdtree::EpochPin pin;
    Deferred deferred;
    collect_deferred(context.tree.root(), deferred);
    const bool some_are_marked = context.tree.left_over_bytes() > 0;
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
  complete(context, *first, counters, cancelled);
  return kdtree::load(*first) != was;
}

void LazyTree::expand_all(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled) {
  if (is_complete()) return;
  const Timed timed(counters);
  while (!is_set(cancelled) && build_left_over(context_, nullptr, counters, cancelled)) continue;
  // A round completes the cells that were deferred when it began, except those that rays claimed.
  for (;;) {
    Deferred deferred;
    const std::uint64_t evicted_before = evicted_.load(std::memory_order_acquire);
    {
      const kdtree::EpochPin pin;
      collect_deferred(context_.tree.root(), deferred);
    }
    // Evicted cells wait for rays, unless all of them fit.
    const bool some_wait =
        deferred.evicted_references > 0 &&
        !context_.has_capacity_for(deferred.evicted_references * kBytesOfReference);
    if (!some_wait) {
      deferred.slots.insert(deferred.slots.end(), deferred.evicted.begin(), deferred.evicted.end());
    }
    if (deferred.slots.empty() && !some_wait) {
      complete_.store(true, std::memory_order_release);
      // Something may have gone since they were collected.
      if (evicted_.load(std::memory_order_acquire) != evicted_before) complete_.store(false);
    }
    if (deferred.slots.empty() || is_set(cancelled) || !context_.may_build_ahead()) return;
    complete_each(deferred.slots.size(), counters, [&](std::size_t i, kdtree::BuildCounters& sum) {
      complete(context_, *deferred.slots[i], sum, cancelled);
    });
  }
}

}  // namespace sightline::accel::lazy
