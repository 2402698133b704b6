// Pieces of a tree go, and come back. Membership of references is what their ids are: a compact
// list holds what the piece held, and the source makes their boxes again.
#include "accel/lazy/eviction.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "accel/grow/grow.h"
#include "accel/grow/reference_budget.h"
#include "accel/lazy/demand_costs.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/lazy/long_list.h"

namespace sightline::accel::lazy {
namespace {

/// What all of a thousand bytes cost to build again, by how many batches ago they were used.
std::uint64_t value_of(std::uint64_t cost_of_reference, std::uint64_t bytes_of_reference,
                       const kdtree::LastUse& use) {
  constexpr std::uint64_t kScale = std::uint64_t{1} << 32;
  return cost_of_reference * kScale / bytes_of_reference / (1 + std::uint64_t{use.age()});
}

bool is_wanted(const kdtree::DeferredCell& cell) {
  const kdtree::RefCounted* work = cell.task.load(std::memory_order_acquire);
  return work != nullptr && static_cast<const CellTask*>(work)->is_wanted();
}

/// The same references at the same place, and what rays have spent on them.
std::unique_ptr<kdtree::DeferredCell> without_list(const kdtree::DeferredCell& cell) {
  auto fresh = std::make_unique<kdtree::DeferredCell>();
  fresh->box = cell.box;
  fresh->path = cell.path;
  fresh->left_over = cell.left_over;
  fresh->size = cell.size;
  fresh->weight = cell.weight;
  fresh->spent = cell.spent.load(std::memory_order_relaxed);
  return fresh;
}

}  // namespace

bool LazyTree::is_evictable() const {
  return tree_.memory() != nullptr && makes_blocks() && source_.again;
}

/// A long list that is divided without room leaves compact ones, an eighth of it.
bool LazyTree::may_grow(const kdtree::DeferredCell& cell) const {
  if (is_list_) return false;
  if (tree_.memory() == nullptr || tree_.memory()->may_grow()) return true;
  return is_evictable() && cell.has_list && !cell.list.is_compact() &&
         cell.list.size() >= kdtree::kLongList;
}

bool LazyTree::may_build_ahead() const {
  return tree_.memory() == nullptr || tree_.memory()->may_build_ahead();
}

/// Whether evicted cells with that number of references wait for rays: not all of them fit.
bool LazyTree::evicted_must_wait(std::uint64_t references) const {
  const kdtree::TreeMemory* memory = tree_.memory();
  return references > 0 && memory != nullptr &&
         memory->held() + references * kBytesOfReference > memory->low_water();
}

void LazyTree::list_evictable(std::vector<Evictable>& found) {
  if (is_evictable()) list_evictable(tree_.root(), tree_.bounds(), 0, found);
}

void LazyTree::list_evictable(kdtree::AtomicSlot& slot, const geometry::Aabb& cell, int depth,
                              std::vector<Evictable>& found) {
  const kdtree::Slot now = kdtree::load(slot);
  if (now.is_finished()) {
    const kdtree::FinishedSubtree& subtree = *now.finished();
    found.push_back({&slot, cell, depth, subtree.size_in_bytes(),
                     value_of(kFinishCost, kBytesOfReference, subtree.last_use)});
  } else if (now.is_deferred() && !now.is_expanding()) {
    const kdtree::DeferredCell& waiting = *now.cell();
    if (!waiting.has_list || waiting.list.is_compact() || waiting.openable ||
        waiting.list.size() < kFewestToEvict || is_wanted(waiting))
      return;
    found.push_back({&slot, cell, depth, waiting.list.bytes(),
                     value_of(kListCost, sizeof(kdtree::Reference), waiting.last_use)});
  } else if (now.is_node()) {
    // A cell's own box is in its list; that of a finished one is its box in the node.
    for (std::size_t i = 0; i < kdtree::kWidth; ++i) {
      const geometry::Aabb box = now.node()->box(i);
      const geometry::Vec3f& center = frame_.center;
      list_evictable(now.node()->slot(i), {box.lo + center, box.hi + center}, depth + 1, found);
    }
  }
}

std::uint64_t LazyTree::evict(const Evictable& piece) {
  const kdtree::Slot now = kdtree::load(*piece.slot);
  std::uint64_t before = 0;
  std::unique_ptr<kdtree::DeferredCell> cell;
  if (now.is_finished()) {
    before = now.finished()->size_in_bytes();
    cell = evicted_subtree(piece, *now.finished());
  } else if (now.is_deferred() && !now.is_expanding() && !now.cell()->list.is_compact() &&
             now.cell()->has_list && !now.cell()->openable && now.cell()->list.size() > 0) {
    before = now.cell()->size_in_bytes();
    cell = with_compact_list(*now.cell());
  } else {
    return 0;
  }
  const std::uint64_t after = cell->size_in_bytes();
  const kdtree::Slot evicted = tree_.defer(std::move(cell));
  if (!tree_.replace(*piece.slot, now, evicted)) return 0;
  if (now.is_finished()) {
    evicted_.fetch_add(1, std::memory_order_acq_rel);
    complete_.store(false, std::memory_order_release);
  }
  return before - std::min(before, after);
}

/// Its path is that of a root of the same references: a budget is what the subtree took.
std::unique_ptr<kdtree::DeferredCell> LazyTree::evicted_subtree(
    const Evictable& piece, const kdtree::FinishedSubtree& subtree) {
  std::vector<std::uint32_t> ids = subtree.ids();
  const std::size_t held = ids.size();
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  auto cell = std::make_unique<kdtree::DeferredCell>();
  cell->box = piece.cell;
  cell->size = ids.size();
  cell->weight = ids.size();
  cell->evicted = true;
  if (budget() != 0)
    cell->path =
        grow::root_path(static_cast<double>(held) / static_cast<double>(ids.size()), ids.size());
  cell->path.depth = piece.depth;
  cell->has_list = !holds_all(*cell);
  ids.shrink_to_fit();
  if (cell->has_list) cell->list = kdtree::CellList(std::move(ids));
  return cell;
}

std::unique_ptr<kdtree::DeferredCell> LazyTree::with_compact_list(
    const kdtree::DeferredCell& cell) const {
  std::unique_ptr<kdtree::DeferredCell> fresh = without_list(cell);
  fresh->whole = cell.whole;
  fresh->evicted = cell.evicted;
  fresh->has_list = !holds_all(cell);
  if (!fresh->has_list) return fresh;
  std::vector<std::uint32_t> ids;
  ids.reserve(cell.list.size());
  cell.list.any_part([&](std::span<const kdtree::Reference> refs) {
    for (const kdtree::Reference& ref : refs) ids.push_back(ref.id);
    return false;
  });
  fresh->list = kdtree::CellList(std::move(ids));
  return fresh;
}

kdtree::ReferenceList LazyTree::list_again(const kdtree::DeferredCell& cell,
                                           kdtree::BuildCounters& counters) const {
  kdtree::ReferenceList list(cell.list.size());
  source_.again(cell.list.ids(), list.all().data(), counters);
  return list;
}

/// The same cell, not of the tree. A long list is in slices, so that no thread needs a buffer for
/// all of it.
std::unique_ptr<kdtree::DeferredCell> LazyTree::with_list_again(
    const kdtree::DeferredCell& cell, kdtree::BuildCounters& counters) const {
  std::unique_ptr<kdtree::DeferredCell> fresh = without_list(cell);
  if (cell.list.size() < kdtree::kLongList) {
    fresh->list = kdtree::CellList(list_again(cell, counters));
    return fresh;
  }
  std::vector<kdtree::SlicedList::Piece> pieces;
  for (std::span<const std::uint32_t> ids = cell.list.ids(); !ids.empty();) {
    const std::span<const std::uint32_t> slice =
        ids.first(std::min(ids.size(), kdtree::kReferencesPerSlice));
    ids = ids.subspan(slice.size());
    kdtree::ReferenceList list(slice.size());
    source_.again(slice, list.all().data(), counters);
    pieces.push_back(std::make_shared<const kdtree::ReferenceList>(std::move(list)));
  }
  fresh->list = make_list(std::move(pieces));
  return fresh;
}

bool LazyTree::has_capacity_for(std::uint64_t bytes) const {
  const kdtree::TreeMemory* memory = tree_.memory();
  return memory == nullptr || memory->held() + bytes <= memory->low_water();
}

/// Lists that do not fit are not kept: the eviction of each would keep rays from growing the tree.
void LazyTree::heed_capacity(Division& division) const {
  if (!is_evictable() || !division.is_cut) return;
  std::uint64_t bytes = 0;
  for (const NewCell& fresh : division.cells) bytes += fresh.part.list.bytes();
  division.compact = !has_capacity_for(bytes);
}

/// A claimed cell with a compact list. With room, several threads may divide a long list; without,
/// this thread does, and its list is never another thread's to wait for.
void LazyTree::divide_compact(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                              kdtree::BuildCounters& counters) {
  const std::uint64_t bytes = cell.list.size() * sizeof(kdtree::Reference);
  const bool has_capacity = has_capacity_for(2 * bytes);
  grow::GrowingBytes growing(tree_, 2 * bytes);  // the list, and those of the new cells
  std::unique_ptr<kdtree::DeferredCell> listed = with_list_again(cell, counters);
  const bool is_long = listed->list.sliced() != nullptr;
  CellTask alone(nullptr);
  Division division;
  if (!is_long) {
    division = divide_short(context_, *listed, counters);
  } else if (!has_capacity) {
    division = divide_long(context_, *listed, PassSequence(alone, counters, nullptr), counters);
  }
  division.compact = !has_capacity;
  if ((is_long && has_capacity) || !may_wait(division, *listed)) {
    growing.shrink(0);
    publish(slot, cell, tree_.defer(std::move(listed)), counters);
    return;
  }
  publish(slot, cell, make_slot(std::move(division), *listed), counters);
}

}  // namespace sightline::accel::lazy
