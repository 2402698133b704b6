// Expanding deferred cells: build off to the side, publish with one store, retire.
#include "accel/lazy/lazy_tree.h"

#include <limits>
#include <memory>
#include <new>
#include <utility>

#include "accel/grow/grow.h"
#include "accel/kdtree/epoch.h"
#include "accel/lazy/opening.h"
#include "accel/lazy/stall_detector.h"
#include "accel/lazy/timed.h"

namespace sightline::accel::lazy {
namespace {

/// How many references the cuts of a tree over `references` may add.
double budget(const split::SplitSearch& rule, std::size_t references) {
  if (rule.budget() == 0) return std::numeric_limits<double>::infinity();
  return (rule.budget() - 1) * static_cast<double>(references);
}

bool is_large(const kdtree::DeferredCell& cell) {
  return !cell.listed || cell.list.sliced() != nullptr;
}

Expansion& expansion_of(kdtree::DeferredCell& cell, const ReferenceSource& source, bool& fresh) {
  kdtree::SharedWork* work = cell.expansion.load(std::memory_order_acquire);
  fresh = false;
  if (work == nullptr) {
    auto* mine = new Expansion(source.alive);
    fresh = cell.expansion.compare_exchange_strong(work, mine, std::memory_order_acq_rel);
    if (fresh) return *mine;
    mine->leave();
  }
  return static_cast<Expansion&>(*work);
}

}  // namespace

LazyTree::LazyTree(const geometry::Aabb& bounds, std::size_t closed, split::SplitRule rule,
                   ReferenceSource source, const geometry::MeshView* mesh)
    : tree_(bounds, closed, {.spare = budget(*rule, closed)}),
      rule_(std::move(rule)),
      source_(std::move(source)),
      closed_(closed),
      context_{rule_, source_, mesh, grow::depth_limit(*rule_, closed)} {}

Expanded LazyTree::expand(kdtree::AtomicSlot& slot, AtBusy at_busy,
                          kdtree::BuildCounters& counters) {
  const Timed timed(counters);
  return expand_now(slot, at_busy, counters);
}

Expanded LazyTree::expand_now(kdtree::AtomicSlot& slot, AtBusy at_busy,
                              kdtree::BuildCounters& counters) {
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_unbuilt()) return Expanded::kAgain;
  kdtree::DeferredCell& cell = *now.cell();
  if (cell.given_up.load(std::memory_order_relaxed)) return Expanded::kSearch;
  if (now.tag() == kdtree::Slot::Tag::kExpanding) return meet_claimed(slot, cell, at_busy);
  try {
    return is_large(cell) ? expand_large(slot, cell, at_busy, counters)
                          : expand_small(slot, cell, counters);
  } catch (const std::bad_alloc&) {
    cell.given_up.store(true, std::memory_order_relaxed);
    return Expanded::kSearch;
  }
}

/// Another thread has claimed the cell. Searching a short list takes less time than waiting for it.
/// A long list, claimed by a full build, is only searched if the thread makes no progress.
Expanded LazyTree::meet_claimed(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell,
                                AtBusy at_busy) {
  if (!is_large(cell)) return Expanded::kSearch;
  if (at_busy == AtBusy::kLeave) return Expanded::kBusy;
  for (Patience patience; patience.wait(0);) {
    if (kdtree::load(slot) != kdtree::Slot::expanding(&cell)) return Expanded::kAgain;
  }
  return Expanded::kSearch;
}

std::uint64_t LazyTree::progress(const kdtree::AtomicSlot& slot) {
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_unbuilt()) return 0;
  const kdtree::SharedWork* work = now.cell()->expansion.load(std::memory_order_acquire);
  return work == nullptr ? 0 : static_cast<const Expansion*>(work)->progress();
}

bool LazyTree::claim(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell) {
  std::uint64_t expected = kdtree::Slot::deferred(&cell).bits();
  return slot.compare_exchange_strong(expected, kdtree::Slot::expanding(&cell).bits(),
                                      std::memory_order_acq_rel);
}

void LazyTree::give_back(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell) {
  cell.given_up.store(true, std::memory_order_relaxed);
  slot.store(kdtree::Slot::deferred(&cell).bits(), std::memory_order_release);
}

/// Called by one thread only: the one that claimed the cell.
void LazyTree::publish(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, kdtree::Slot built,
                       kdtree::BuildCounters& counters) {
  slot.store(built.bits(), std::memory_order_release);
  tree_.retire_cell(cell);
  counters.cells_expanded += built.is_unbuilt() ? 0u : 1u;
}

/// The cell's own list is never written, because other threads may be searching it.
Expanded LazyTree::expand_small(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                                kdtree::BuildCounters& counters) {
  if (!claim(slot, cell))
    return kdtree::load(slot) == kdtree::Slot::expanding(&cell) ? Expanded::kSearch
                                                                : Expanded::kAgain;
  try {
    const kdtree::Slot built = cell.weight <= kFinishBelow
                                   ? finish(cell, counters, nullptr)
                                   : make_slot(divide_short(context_, cell, counters), cell);
    publish(slot, cell, built, counters);
    return Expanded::kAgain;
  } catch (const std::bad_alloc&) {
    give_back(slot, cell);
    return Expanded::kSearch;
  }
}

Expanded LazyTree::expand_large(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                                AtBusy at_busy, kdtree::BuildCounters& counters) {
  bool fresh = false;
  Expansion& expansion = expansion_of(cell, source_, fresh);
  if (fresh) return lead(slot, cell, expansion, counters);
  for (Patience patience;;) {
    const bool helped = expansion.help(counters);
    if (kdtree::load(slot) != kdtree::Slot::deferred(&cell)) return Expanded::kAgain;
    if (helped) continue;
    if (at_busy == AtBusy::kLeave) return Expanded::kBusy;
    if (!patience.wait(expansion.progress())) return lead(slot, cell, expansion, counters);
  }
}

/// Runs the stages to their end. Several threads may do so if the first one seemed to be stopped;
/// then the first result is published and the others are discarded.
Expanded LazyTree::lead(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, Expansion& expansion,
                        kdtree::BuildCounters& counters) {
  tree_.reserve(closed_);
  const kdtree::Slot built =
      make_slot(divide_long(context_, cell, Replay(expansion, counters), counters), cell);
  std::uint64_t expected = kdtree::Slot::deferred(&cell).bits();
  if (slot.compare_exchange_strong(expected, built.bits(), std::memory_order_acq_rel)) {
    counters += expansion.take_counters();
    tree_.retire_cell(cell);
    counters.cells_expanded += built.is_unbuilt() ? 0u : 1u;
  } else {
    tree_.discard(built);
  }
  return Expanded::kAgain;
}

kdtree::Slot LazyTree::defer(NewCell now) {
  auto cell = std::make_unique<kdtree::DeferredCell>();
  cell->box = now.box;
  cell->path = now.path;
  cell->openable = now.part.openable;
  cell->size = now.part.list.size();
  cell->weight = now.weight;
  cell->first = now.part.first;
  cell->list = std::move(now.part.list);
  return tree_.defer(std::move(cell));
}

kdtree::Slot LazyTree::make_slot(Division division, const kdtree::DeferredCell& cell) {
  if (!division.cuts.empty()) return make_slot(division, division.cuts[0]);
  if (!division.cells.empty()) return defer(std::move(division.cells[0]));
  const kdtree::BoxList whole = cell.list.copy();
  const std::optional<kdtree::Slot> leaf = tree_.make_leaf(whole.all());
  if (!leaf) throw std::bad_alloc();
  return *leaf;
}

kdtree::Slot LazyTree::make_slot(Division& division, const CutTree::Node& node) {
  const std::optional<std::uint32_t> pair = tree_.allocate_pair();
  if (!pair) throw std::bad_alloc();
  const kdtree::Slot slot = kdtree::Slot::binary(node.cut.plane, *pair);
  const auto below = [&](const CutTree::Child& child) {
    return child.is_part ? defer(std::move(division.cells[child.place]))
                         : make_slot(division, division.cuts[child.place]);
  };
  kdtree::AtomicSlot* children = tree_.children(slot);
  children[0].store(below(node.left).bits(), std::memory_order_relaxed);
  children[1].store(below(node.right).bits(), std::memory_order_relaxed);
  return slot;
}

kdtree::Slot LazyTree::finish(const kdtree::DeferredCell& cell, kdtree::BuildCounters& counters,
                              const std::atomic<bool>* cancelled) {
  kdtree::BoxList list = cell.list.copy();
  if (cell.openable) list = open_all(source_, std::move(list), cell.box, counters);
  const grow::GrowContext context{tree_, *rule_, context_.mesh, context_.max_depth, cancelled};
  return grow::grow(context, list.all(), cell.box, cell.path, counters);
}

}  // namespace sightline::accel::lazy
