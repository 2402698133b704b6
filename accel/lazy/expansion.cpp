// Expanding deferred cells: build off to the side, publish with one store, retire.
#include "accel/lazy/expansion.h"

#include <algorithm>
#include <cassert>
#include <memory>
#include <utility>

#include "accel/grow/fork.h"
#include "accel/grow/subtrees.h"
#include "accel/lazy/cell_reader.h"
#include "accel/lazy/eviction.h"
#include "accel/lazy/full_build.h"
#include "accel/lazy/opening.h"
#include "accel/lazy/stall_detector.h"

namespace sightline::accel::lazy {
namespace {

using kdtree::DeferredCell;

bool is_large(const DeferredCell& cell) { return !cell.has_list || cell.size >= kdtree::kLongList; }

std::uint64_t list_bytes(const Division& division) {
  std::uint64_t bytes = 0;
  for (const auto& cell : division.cells) bytes += cell->list.bytes();
  return bytes;
}

PassChain& passes_of(DeferredCell& cell, const ReferenceSource& source) {
  kdtree::RefCounted* passes = cell.passes.load(std::memory_order_acquire);
  if (passes == nullptr) {
    auto* mine = new PassChain(source.alive);
    if (cell.passes.compare_exchange_strong(passes, mine, std::memory_order_acq_rel)) return *mine;
    mine->leave();
  }
  return static_cast<PassChain&>(*passes);
}

}  // namespace

kdtree::Slot Expansion::slot_of(const DeferredCell& cell) const {
  return claimed_ == &cell ? kdtree::Slot::expanding(&cell) : kdtree::Slot::deferred(&cell);
}

bool Expansion::claim(DeferredCell& cell) {
  std::uint64_t expected = slot_of(cell).bits();
  if (!slot_.compare_exchange_strong(expected, kdtree::Slot::expanding(&cell).bits(),
                                     std::memory_order_acq_rel))
    return false;
  claimed_ = &cell;
  return true;
}

void Expansion::release() {
  if (claimed_ != nullptr)
    slot_.store(kdtree::Slot::deferred(std::exchange(claimed_, nullptr)).bits(),
                std::memory_order_release);
}

/// Several threads may divide a large cell, if the first one seemed to be stopped: the first result
/// is published.
void Expansion::publish(DeferredCell& cell, kdtree::Slot next) {
  const kdtree::Slot now = slot_of(cell);
  const bool is_root = &slot_ == &context_.tree.root();
  const bool is_deferred = next.is_deferred();
  if (!context_.tree.replace(slot_, now, next)) return;
  claimed_ = nullptr;
  if (passes_ != nullptr) counters_ += passes_->take_counters();
  if (is_deferred) return;
  ++counters_.cells_expanded;
  counters_.trees_begun += is_root ? 1 : 0;
}

AtCell Expansion::expand(bool waits) {
  const kdtree::Slot now = kdtree::load(slot_);
  if (!now.is_deferred()) return AtCell::kAdvance;
  DeferredCell& cell = *now.cell();
  if (is_set(cancelled_)) return AtCell::kSearch;
  if (now.is_expanding()) return wait_for_owner(cell, waits);
  const bool at_once =
      cell.whole || (context_.is_eager(cell) && (cell.has_list || context_.makes_blocks));
  try {
    if (is_large(cell) && !at_once) return expand_shared(cell, waits);
    if (!claim(cell))
      return kdtree::load(slot_) == kdtree::Slot::expanding(&cell) ? AtCell::kSearch
                                                                   : AtCell::kAdvance;
    expand_claimed(cell, at_once);
    return AtCell::kAdvance;
  } catch (const Cancelled&) {
    return AtCell::kSearch;
  }
}

/// Another thread has claimed the cell. Searching a short list takes less time than waiting for it.
/// A long list, claimed by a full build, is only searched if the thread makes no progress.
AtCell Expansion::wait_for_owner(const DeferredCell& cell, bool waits) {
  if (!is_large(cell)) return AtCell::kSearch;
  if (!waits) return AtCell::kStop;
  for (StallDetector stall_detector; !is_set(cancelled_) && stall_detector.wait(0);) {
    if (kdtree::load(slot_) != kdtree::Slot::expanding(&cell)) return AtCell::kAdvance;
  }
  return AtCell::kSearch;
}

/// The first thread runs the passes to their end. Others help, and run them, too, if it seems to be
/// stopped.
AtCell Expansion::expand_shared(DeferredCell& cell, bool waits) {
  passes_ = &passes_of(cell, *context_.source);
  const PassChain::Wanted wanted(*passes_);
  const auto has_changed = [&] { return kdtree::load(slot_) != kdtree::Slot::deferred(&cell); };
  if (has_changed()) return AtCell::kAdvance;
  StallDetector stall_detector;
  while (!wanted.is_first()) {
    const bool helped = passes_->help(counters_, cancelled_);
    if (has_changed()) return AtCell::kAdvance;
    if (helped) continue;
    if (!waits) return AtCell::kStop;
    if (!stall_detector.wait(passes_->progress())) break;
  }
  if (!divide_cell(cell, Passes(*passes_, counters_, cancelled_))) mark_whole(cell);
  return AtCell::kAdvance;
}

/// The cell's own list is never written, because other threads may be searching it.
void Expansion::expand_claimed(DeferredCell& cell, bool at_once) {
  if (!at_once && divide_cell(cell, Passes(counters_))) return;
  if (cell.size >= grow::kForkFrom && lists_are_left_over(context_)) {
    release();
    if (build_left_over(context_, &slot_, counters_, cancelled_) || !claim(cell)) return;
  }
  if (cell.has_list && context_.holds_all(cell) && !context_.is_eager(cell)) {
    mark_whole(cell);
  } else {
    build_claimed();
  }
}

/// Publishes what the cell becomes. False if the new cells may not wait. A compact list that is
/// short, or that there is no room for, is made for this thread alone.
bool Expansion::divide_cell(DeferredCell& cell, const Passes& passes) {
  const bool is_compact = cell.list.is_compact();
  const std::uint64_t bytes = cell.size * sizeof(kdtree::Reference);
  grow::GrowingBytes growing(context_.tree, is_compact || is_large(cell) ? bytes : 0);
  Division division = divide(context_, cell, passes, fill_above(cell));
  if (is_compact && division.is_finer() && !(is_large(cell) && context_.has_capacity_for(bytes))) {
    const std::unique_ptr<DeferredCell> listed = std::move(division.cells[0]);
    growing.reach(2 * bytes);
    division = divide(context_, *listed, Passes(counters_), fill_above(cell));
  }
  if (!may_wait(division, cell)) return false;
  if (kdtree::load(slot_) != slot_of(cell)) return true;
  // Lists that do not fit are not kept: the eviction of each would keep rays from growing the tree.
  if (division.is_cut && context_.is_evictable() &&
      !context_.has_capacity_for(list_bytes(division))) {
    for (std::unique_ptr<DeferredCell>& fresh : division.cells) {
      if (!fresh->openable && fresh->size >= kFewestToEvict)
        fresh = with_compact_list(context_, *fresh);
    }
  }
  growing.shrink(0);  // the new cells count their lists
  publish(cell, make_slot(std::move(division), cell));
  return true;
}

/// Whether the new cells may take the place of `cell` with their lists. If not, the subtree of
/// `cell` is built at once. In a tree with a budget of references, they may not if all deferred
/// cells with their lists would then exceed most_list_bytes(), or if the lists of the parts of a
/// large cell hold a quarter more references than its own: further cuts are expected to add as
/// many.
bool Expansion::may_wait(const Division& division, const DeferredCell& cell) const {
  constexpr std::uint64_t kLargePart = 8, kStraddleShare = 4;
  if (context_.budget() == 0 || !division.is_cut) return true;
  std::uint64_t size = 0;
  for (const auto& fresh : division.cells) size += fresh->size;
  const std::uint64_t bytes = list_bytes(division);
  if (bytes > kSpareBytes && !cell.openable && cell.size * kLargePart >= context_.size &&
      size * kStraddleShare >= cell.size * (kStraddleShare + 1)) {
    return false;
  }
  return context_.tree.deferred_bytes() + bytes - cell.list.bytes() <= most_list_bytes(context_);
}

kdtree::Slot Expansion::make_slot(Division division, const DeferredCell& cell) {
  if (division.is_cut) return make_node(std::move(division));
  if (division.is_finer()) return context_.tree.defer(std::move(division.cells[0]));
  const kdtree::ReferenceList list =
      CellReader(context_.source, cell, counters_).read_all(counters_);
  const grow::GrowContext context = grow_context();
  grow::Subtrees subtrees(context);
  return subtrees.compile(subtrees.finish(list.all(), cell.box));
}

/// In trees over instances a short list becomes as many cells as a node holds, since rays come to
/// most of them.
std::uint64_t Expansion::fill_above(const DeferredCell& cell) const {
  const bool is_short = cell.has_list && cell.list.slices() == 1;
  return is_short && context_.mesh == nullptr ? std::min(kEagerBelow, fill_above_) : fill_above_;
}

kdtree::Slot Expansion::make_node(Division division) {
  assert(division.cells.size() <= kdtree::kWidth);
  kdtree::WideNode* const node = context_.tree.make_node();
  std::size_t children = 0;
  for (std::size_t i = 0; i < division.cells.size(); ++i) {
    std::unique_ptr<DeferredCell>& cell = division.cells[i];
    if (cell->size == 0) continue;
    node->set_box(children, in_frame(context_.frame, division.boxes[i]));
    const kdtree::Slot slot = context_.tree.defer(std::move(cell));
    node->children[children++].store(slot.bits(), std::memory_order_relaxed);
  }
  return kdtree::Slot::node(node);
}

grow::GrowContext Expansion::grow_context() const {
  return {context_.tree,  *context_.rule,     context_.mesh,
          context_.frame, context_.max_depth, cancelled_};
}

bool Expansion::build_claimed() {
  if (claimed_ == nullptr) return false;
  DeferredCell& cell = *claimed_;
  try {
    const CellReader reader(context_.source, cell, counters_);
    kdtree::ReferenceList list = reader.read_all(counters_, cancelled_);
    if (reader.openable()) list = open_all(*context_.source, std::move(list), cell.box, counters_);
    kdtree::CellPath path = cell.path;
    if (cell.has_list)
      path.list_capacity -= static_cast<double>(list.size());  // the cell's own waits
    const grow::GrowContext context = grow_context();
    publish(cell, grow::grow(context, std::move(list), cell.box, path, counters_));
  } catch (const Cancelled&) {  // it is deferred again
  }
  return true;
}

void Expansion::mark_whole(DeferredCell& cell) {
  std::unique_ptr<DeferredCell> fresh = copy_without_list(cell);
  fresh->has_list = !context_.holds_all(cell);
  fresh->whole = true;
  if (fresh->has_list) fresh->list = cell.list;
  publish(cell, context_.tree.defer(std::move(fresh)));
}

}  // namespace sightline::accel::lazy
