// Expanding deferred cells: build off to the side, publish with one store, retire.
#include "accel/lazy/lazy_tree.h"

#include <algorithm>
#include <cassert>
#include <memory>
#include <new>
#include <utility>

#include "accel/grow/fork.h"
#include "accel/grow/grow.h"
#include "accel/grow/reference_budget.h"
#include "accel/grow/subtrees.h"
#include "accel/kdtree/epoch.h"
#include "accel/lazy/demand_costs.h"
#include "accel/lazy/eviction.h"
#include "accel/lazy/stall_detector.h"
#include "accel/lazy/timed.h"

namespace sightline::accel::lazy {
namespace {

/// What of a list lies in its cell.
geometry::Aabb bounds_in(const geometry::Aabb& cell, const kdtree::CellList& list) {
  geometry::Aabb box;
  list.any_part([&](std::span<const kdtree::Reference> refs) {
    for (const kdtree::Reference& ref : refs) box.grow(ref.bounds());
    return false;
  });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lo[axis] = std::max(box.lo[axis], cell.lo[axis]);
    box.hi[axis] = std::min(box.hi[axis], cell.hi[axis]);
  }
  return box;
}

/// Faces end in leaf blocks, unless floats are too coarse or too short for their sizes.
bool may_make_blocks(const geometry::MeshView* mesh, const geometry::Aabb& bounds) {
  return mesh != nullptr && !bounds.empty() && wide::frame_of(bounds).scale == 1;
}

bool is_large(const kdtree::DeferredCell& cell) {
  return !cell.has_list || cell.list.sliced() != nullptr;
}

CellTask& task_of(kdtree::DeferredCell& cell, const ReferenceSource& source) {
  kdtree::RefCounted* work = cell.task.load(std::memory_order_acquire);
  if (work == nullptr) {
    auto* mine = new CellTask(source.alive);
    if (cell.task.compare_exchange_strong(work, mine, std::memory_order_acq_rel)) return *mine;
    mine->leave();
  }
  return static_cast<CellTask&>(*work);
}

}  // namespace

LazyTree::LazyTree(const geometry::Aabb& bounds, std::size_t primitive_count, split::SplitRule rule,
                   ReferenceSource source, const geometry::MeshView* mesh,
                   std::shared_ptr<kdtree::TreeMemory> memory)
    : tree_(bounds, primitive_count,
            grow::root_path(rule->budget(may_make_blocks(mesh, bounds)), primitive_count),
            std::move(memory)),
      rule_(std::move(rule)),
      source_(std::move(source)),
      primitive_count_(primitive_count),
      context_{rule_, source_, mesh, grow::depth_limit(primitive_count)},
      frame_(wide::frame_of(bounds)),
      makes_blocks_(may_make_blocks(mesh, bounds)),
      is_list_(mesh != nullptr && !bounds.empty() && !makes_blocks_),
      complete_(is_list_) {}

double LazyTree::budget() const { return rule_->budget(makes_blocks()); }

bool LazyTree::is_eager(const kdtree::DeferredCell& cell) const {
  if (!makes_blocks()) return cell.weight <= kEagerBelow;
  return cell.weight <= (cell.size == primitive_count_ ? kWholeMesh : grow::kBlockCell);
}

ExpandResult LazyTree::expand(kdtree::AtomicSlot& slot, WhenPending when_pending,
                              kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled) {
  const Timed timed(counters);
  const kdtree::Slot now = kdtree::load(slot);
  if (now.is_deferred() && !may_grow(*now.cell())) return ExpandResult::kScanList;
  return expand_now(slot, when_pending, counters, cancelled);
}

ExpandResult LazyTree::expand_now(kdtree::AtomicSlot& slot, WhenPending when_pending,
                                  kdtree::BuildCounters& counters,
                                  const std::atomic<bool>* cancelled) {
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_deferred()) return ExpandResult::kRetry;
  kdtree::DeferredCell& cell = *now.cell();
  if (is_set(cancelled)) return ExpandResult::kScanList;
  if (now.is_expanding()) return wait_for_owner(slot, cell, when_pending, cancelled);
  try {
    const bool whole = cell.whole || (makes_blocks() && !cell.has_list && is_eager(cell));
    return is_large(cell) && !whole ? expand_large(slot, cell, when_pending, counters, cancelled)
                                    : expand_claimed(slot, cell, counters, cancelled);
  } catch (const Cancelled&) {
    return ExpandResult::kScanList;
  }
}

/// Another thread has claimed the cell. Searching a short list takes less time than waiting for it.
/// A long list, claimed by a full build, is only searched if the thread makes no progress.
ExpandResult LazyTree::wait_for_owner(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell,
                                      WhenPending when_pending,
                                      const std::atomic<bool>* cancelled) {
  if (!is_large(cell)) return ExpandResult::kScanList;
  if (when_pending == WhenPending::kReturn) return ExpandResult::kPending;
  for (StallDetector stall_detector; !is_set(cancelled) && stall_detector.wait(0);) {
    if (kdtree::load(slot) != kdtree::Slot::expanding(&cell)) return ExpandResult::kRetry;
  }
  return ExpandResult::kScanList;
}

std::uint64_t LazyTree::progress(const kdtree::AtomicSlot& slot) {
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_deferred()) return 0;
  const kdtree::RefCounted* work = now.cell()->task.load(std::memory_order_acquire);
  return work == nullptr ? 0 : static_cast<const CellTask*>(work)->progress();
}

bool LazyTree::claim(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell) {
  std::uint64_t expected = kdtree::Slot::deferred(&cell).bits();
  return slot.compare_exchange_strong(expected, kdtree::Slot::expanding(&cell).bits(),
                                      std::memory_order_acq_rel);
}

void LazyTree::release_claim(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell) {
  slot.store(kdtree::Slot::deferred(&cell).bits(), std::memory_order_release);
}

/// Called by one thread only: the one that claimed the cell.
void LazyTree::publish(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, kdtree::Slot built,
                       kdtree::BuildCounters& counters) {
  tree_.replace(slot, kdtree::Slot::expanding(&cell), built);
  count(slot, built, counters);
}

void LazyTree::count(const kdtree::AtomicSlot& slot, kdtree::Slot built,
                     kdtree::BuildCounters& counters) {
  if (built.is_deferred()) return;
  ++counters.cells_expanded;
  if (&slot == &tree_.root()) ++counters.trees_begun;
}

/// By one thread: divides a cell with a short list, or builds a whole subtree. The cell's own list
/// is never written, because other threads may be searching it.
ExpandResult LazyTree::expand_claimed(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                                      kdtree::BuildCounters& counters,
                                      const std::atomic<bool>* cancelled) {
  if (!claim(slot, cell))
    return kdtree::load(slot) == kdtree::Slot::expanding(&cell) ? ExpandResult::kScanList
                                                                : ExpandResult::kRetry;
  if (!cell.whole && !is_eager(cell)) {
    try {
      if (cell.list.is_compact()) {
        divide_compact(slot, cell, counters);
        return ExpandResult::kRetry;
      }
      Division division = divide_short(context_, cell, counters);
      heed_capacity(division);
      if (may_wait(division, cell)) {
        publish(slot, cell, make_slot(std::move(division), cell), counters);
        return ExpandResult::kRetry;
      }
    } catch (const std::bad_alloc&) {
      release_claim(slot, cell);
      throw;
    }
  }
  if (cell.size >= grow::kForkFrom && lists_are_left_over()) {
    slot.store(kdtree::Slot::deferred(&cell).bits(), std::memory_order_release);
    if (build_left_over(&slot, counters, cancelled)) return ExpandResult::kRetry;
    if (!claim(slot, cell)) return ExpandResult::kRetry;
  }
  if (cell.has_list && holds_all(cell) && !is_eager(cell)) {
    slot.store(kdtree::Slot::deferred(&cell).bits(), std::memory_order_release);
    mark_whole(slot, cell);
    return ExpandResult::kRetry;
  }
  complete_claimed(slot, cell, counters, cancelled);
  return ExpandResult::kRetry;
}

ExpandResult LazyTree::expand_large(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                                    WhenPending when_pending, kdtree::BuildCounters& counters,
                                    const std::atomic<bool>* cancelled) {
  CellTask& task = task_of(cell, source_);
  const CellTask::Wanted wanted(task);
  if (kdtree::load(slot) != kdtree::Slot::deferred(&cell)) return ExpandResult::kRetry;
  if (wanted.is_first()) return run_all_passes(slot, cell, task, counters, cancelled);
  for (StallDetector stall_detector;;) {
    const bool helped = task.help(counters, cancelled);
    if (kdtree::load(slot) != kdtree::Slot::deferred(&cell)) return ExpandResult::kRetry;
    if (helped) continue;
    if (when_pending == WhenPending::kReturn) return ExpandResult::kPending;
    if (!stall_detector.wait(task.progress()))
      return run_all_passes(slot, cell, task, counters, cancelled);
  }
}

/// Runs the passes to their end. Several threads may do so if the first one seemed to be stopped;
/// then the first result is published and the others are discarded.
ExpandResult LazyTree::run_all_passes(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                                      CellTask& task, kdtree::BuildCounters& counters,
                                      const std::atomic<bool>* cancelled) {
  grow::GrowingBytes growing(tree_, cell.size * sizeof(kdtree::Reference));
  Division division =
      divide_long(context_, cell, PassSequence(task, counters, cancelled), counters);
  heed_capacity(division);
  if (!may_wait(division, cell)) {
    mark_whole(slot, cell);
    return ExpandResult::kRetry;
  }
  if (kdtree::load(slot) != kdtree::Slot::deferred(&cell)) return ExpandResult::kRetry;
  if (!division.compact) growing.shrink(0);  // the new cells count them
  const kdtree::Slot built = make_slot(std::move(division), cell);
  if (tree_.replace(slot, kdtree::Slot::deferred(&cell), built)) {
    counters += task.take_counters();
    count(slot, built, counters);
  }
  return ExpandResult::kRetry;
}

kdtree::Slot LazyTree::defer(NewCell now, bool compact) {
  std::unique_ptr<kdtree::DeferredCell> cell = cell_of(std::move(now));
  if (compact && !cell->openable && cell->size >= kFewestToEvict) cell = with_compact_list(*cell);
  return tree_.defer(std::move(cell));
}

grow::GrowContext LazyTree::grow_context(const std::atomic<bool>* cancelled) {
  return {tree_, *rule_, context_.mesh, frame_, context_.max_depth, cancelled};
}

kdtree::Slot LazyTree::make_slot(Division division, const kdtree::DeferredCell& cell) {
  if (division.is_cut) return make_node(division);
  if (!division.cells.empty()) {
    const kdtree::Slot finer = defer(std::move(division.cells[0]));
    // Rays that have searched the cell have searched the finer one.
    const std::uint64_t rays =
        cell.spent.load(std::memory_order_relaxed) / cost_of_search(cell.size);
    if (finer.is_deferred()) finer.cell()->spent = rays * cost_of_search(finer.cell()->size);
    return finer;
  }
  const kdtree::ReferenceList whole = cell.list.copy();
  const grow::GrowContext context = grow_context(nullptr);
  grow::Subtrees subtrees(context);
  return subtrees.compile(subtrees.finish(whole.all(), cell.box));
}

kdtree::Slot LazyTree::make_node(Division& division) {
  assert(division.cells.size() <= kdtree::kWidth);
  // A pass over the lists pays where rays meet many boxes at once.
  const bool is_wide = division.cells.size() > 2;
  kdtree::WideNode* const node = tree_.make_node();
  std::size_t children = 0;
  try {
    for (NewCell& cell : division.cells) {
      const geometry::Aabb box = is_wide ? bounds_in(cell.box, cell.part.list) : cell.box;
      const kdtree::Slot slot = defer(std::move(cell), division.compact);
      if (slot == kdtree::Slot::empty_list()) continue;
      node->set_box(children, in_frame(frame_, box));
      node->children[children++].store(slot.bits(), std::memory_order_relaxed);
    }
  } catch (const std::bad_alloc&) {
    tree_.discard(kdtree::Slot::node(node));
    throw;
  }
  return kdtree::Slot::node(node);
}

std::optional<std::uint32_t> LazyTree::only() const {
  const kdtree::Slot root = kdtree::load(tree_.root());
  if (!root.is_finished()) return std::nullopt;
  const kdtree::Slot leaf = root.finished()->root();
  if (!leaf.is_list() || leaf.list().size() != 1) return std::nullopt;
  return leaf.list().front();
}

}  // namespace sightline::accel::lazy
