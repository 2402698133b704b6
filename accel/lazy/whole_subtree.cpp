// Cells whose subtrees are built at once, because the lists of their children would take too long
// to search or too much memory.
#include <algorithm>
#include <memory>
#include <new>
#include <utility>

#include "accel/grow/grow.h"
#include "accel/grow/subtrees.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/lazy/opening.h"

namespace sightline::accel::lazy {
namespace {

/// Bytes of lists that matter in no mesh; small meshes divide their cells as others do.
constexpr std::uint64_t kSpare = 4096;

/// The list of a root, made by one thread. Throws Cancelled.
kdtree::ReferenceList list_source(const ReferenceSource& source, bool& openable,
                                  kdtree::BuildCounters& counters,
                                  const std::atomic<bool>* cancelled) {
  const ReferenceSource::Coarsest coarsest = source.coarsest(counters);
  openable = coarsest.openable;
  kdtree::ReferenceList list(coarsest.slots);
  std::size_t size = 0;
  for (std::size_t slot = 0; slot < coarsest.slots; slot += kdtree::kReferencesPerSlice) {
    if (is_set(cancelled)) throw Cancelled();
    const std::size_t end = std::min(slot + kdtree::kReferencesPerSlice, coarsest.slots);
    size += source.list(slot, end, list.all().data() + size, counters);
  }
  list.shrink(size);
  return list;
}

/// A copy in one piece. Throws Cancelled.
kdtree::ReferenceList copy(const kdtree::CellList& list, const std::atomic<bool>* cancelled) {
  kdtree::ReferenceList all(list.size());
  kdtree::Reference* end = all.all().data();
  list.any_part([&](std::span<const kdtree::Reference> part) {
    if (is_set(cancelled)) throw Cancelled();
    end = std::copy(part.begin(), part.end(), end);
    return false;
  });
  return all;
}

}  // namespace

/// Whether the source can list the cell again: no cut above has separated anything. Its boxes are
/// then those before clipping.
bool LazyTree::holds_all(const kdtree::DeferredCell& cell) const {
  return !cell.openable && cell.size == primitive_count_;
}

std::uint64_t LazyTree::most_list_bytes() const { return kListBytes * primitive_count_ + kSpare; }

/// Whether the new cells may wait in place of `cell`, beside all others: not if they are too long,
/// nor if a large cell has a share of straddlers that those below will have.
bool LazyTree::may_wait(const Division& division, const kdtree::DeferredCell& cell) const {
  constexpr std::uint64_t kLargePart = 8, kStraddleShare = 4;
  if (budget() == 0 || !division.is_cut) return true;
  std::uint64_t size = 0, bytes = 0;
  for (const NewCell& fresh : division.cells) {
    size += fresh.part.list.size();
    bytes += fresh.part.list.bytes();
  }
  if (bytes > kSpare && !cell.openable && cell.size * kLargePart >= primitive_count_ &&
      size * kStraddleShare >= cell.size * (kStraddleShare + 1)) {
    return false;
  }
  return tree_.deferred_bytes() + bytes - cell.list.bytes() <= most_list_bytes();
}

/// The list of a cell in one piece, for this thread to overwrite. Throws Cancelled.
kdtree::ReferenceList LazyTree::whole_list(const kdtree::DeferredCell& cell, bool& openable,
                                           kdtree::BuildCounters& counters,
                                           const std::atomic<bool>* cancelled) const {
  if (!cell.has_list) return list_source(source_, openable, counters, cancelled);
  if (cell.list.is_compact()) return list_again(cell, counters);
  return copy(cell.list, cancelled);
}

/// Builds the subtree of a claimed cell; if cancelled, a part, whose cells wait with their lists.
/// Throws std::bad_alloc, and Cancelled if it has not begun; then the cell is deferred again.
void LazyTree::complete_claimed(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                                kdtree::BuildCounters& counters,
                                const std::atomic<bool>* cancelled) {
  try {
    bool openable = cell.openable;
    kdtree::ReferenceList list = whole_list(cell, openable, counters, cancelled);
    if (openable) list = open_all(source_, std::move(list), cell.box, counters);
    kdtree::CellPath path = cell.path;
    if (cell.has_list)
      path.list_capacity -= static_cast<double>(list.size());  // the cell's own waits
    const kdtree::Slot built =
        grow::grow(grow_context(cancelled), std::move(list), cell.box, path, counters);
    publish(slot, cell, built, counters);
  } catch (const Cancelled&) {
    slot.store(kdtree::Slot::deferred(&cell).bits(), std::memory_order_release);
    throw;
  } catch (const std::bad_alloc&) {
    release_claim(slot, cell);
    throw;
  }
}

/// Puts a cell in the place of `cell` that will be built at once, without what passes over the list
/// of `cell` have made. A list of everything is made again: it takes as much memory as all else.
void LazyTree::mark_whole(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell) {
  auto fresh = std::make_unique<kdtree::DeferredCell>();
  fresh->box = cell.box;
  fresh->path = cell.path;
  fresh->has_list = !holds_all(cell);
  fresh->openable = cell.openable;
  fresh->size = cell.size;
  fresh->weight = cell.weight;
  fresh->whole = true;
  fresh->spent = cell.spent.load(std::memory_order_relaxed);
  if (fresh->has_list) fresh->list = kdtree::CellList(cell.list.sliced());
  const kdtree::Slot marked = tree_.defer(std::move(fresh));
  tree_.replace(slot, kdtree::Slot::deferred(&cell), marked);
}

}  // namespace sightline::accel::lazy
