// Pieces of a tree go, and come back. Membership of references is what their ids are: a compact
// list holds what the piece held, and the source makes their boxes again.
#include "accel/lazy/eviction.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "accel/grow/reference_budget.h"
#include "accel/lazy/demand_costs.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/lazy/passes.h"

namespace sightline::accel::lazy {
namespace {

/// What all of a thousand bytes cost to build again, by how many batches ago they were used.
std::uint64_t value_of(std::uint64_t cost_of_reference, std::uint64_t bytes_of_reference,
                       const kdtree::LastUse& use) {
  constexpr std::uint64_t kScale = std::uint64_t{1} << 32;
  return cost_of_reference * kScale / bytes_of_reference / (1 + std::uint64_t{use.age()});
}

bool is_wanted(const kdtree::DeferredCell& cell) {
  const kdtree::RefCounted* passes = cell.passes.load(std::memory_order_acquire);
  return passes != nullptr && static_cast<const PassChain*>(passes)->is_wanted();
}

/// Appends what is at and below a slot.
void list_below(const TreeContext& context, kdtree::AtomicSlot& slot, const geometry::Aabb& cell,
                int depth, std::vector<Evictable>& found) {
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
      const geometry::Vec3f& center = context.frame.center;
      list_below(context, now.node()->slot(i), {box.lo + center, box.hi + center}, depth + 1,
                 found);
    }
  }
}

/// Its path is that of a root of the same references: a budget is what the subtree took.
std::unique_ptr<kdtree::DeferredCell> evicted_subtree(const TreeContext& context,
                                                      const Evictable& piece,
                                                      const kdtree::FinishedSubtree& subtree) {
  std::vector<std::uint32_t> ids = subtree.ids();
  const std::size_t held = ids.size();
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  auto cell = std::make_unique<kdtree::DeferredCell>();
  cell->box = piece.cell;
  cell->size = ids.size();
  cell->weight = ids.size();
  cell->evicted = true;
  if (context.budget() != 0)
    cell->path =
        grow::root_path(static_cast<double>(held) / static_cast<double>(ids.size()), ids.size());
  cell->path.depth = piece.depth;
  cell->has_list = !context.holds_all(*cell);
  if (cell->has_list)
    cell->list =
        kdtree::CellList(kdtree::SharedArray<std::uint32_t>(std::span<const std::uint32_t>(ids)));
  return cell;
}

}  // namespace

void LazyTree::list_evictable(std::vector<Evictable>& found) {
  if (context_.is_evictable())
    list_below(context_, context_.tree.root(), context_.tree.bounds(), 0, found);
}

std::uint64_t LazyTree::evict(const Evictable& piece) {
  const kdtree::Slot now = kdtree::load(*piece.slot);
  std::uint64_t before = 0;
  std::unique_ptr<kdtree::DeferredCell> cell;
  if (now.is_finished()) {
    before = now.finished()->size_in_bytes();
    cell = evicted_subtree(context_, piece, *now.finished());
  } else if (now.is_deferred() && !now.is_expanding() && !now.cell()->list.is_compact() &&
             now.cell()->has_list && !now.cell()->openable && now.cell()->list.size() > 0) {
    before = now.cell()->size_in_bytes();
    cell = with_compact_list(context_, *now.cell());
  } else {
    return 0;
  }
  const std::uint64_t after = cell->size_in_bytes();
  const kdtree::Slot evicted = context_.tree.defer(std::move(cell));
  if (!context_.tree.replace(*piece.slot, now, evicted)) return 0;
  if (now.is_finished()) {
    evicted_.fetch_add(1, std::memory_order_acq_rel);
    complete_.store(false, std::memory_order_release);
  }
  return before - std::min(before, after);
}

std::unique_ptr<kdtree::DeferredCell> with_compact_list(const TreeContext& context,
                                                        const kdtree::DeferredCell& cell) {
  std::unique_ptr<kdtree::DeferredCell> fresh = copy_without_list(cell);
  fresh->whole = cell.whole;
  fresh->evicted = cell.evicted;
  fresh->has_list = !context.holds_all(cell);
  if (!fresh->has_list) return fresh;
  kdtree::SharedArray<std::uint32_t> ids(cell.list.size());
  std::uint32_t* end = ids.all().data();
  cell.list.any_part([&](std::span<const kdtree::Reference> refs) {
    for (const kdtree::Reference& ref : refs) *end++ = ref.id;
    return false;
  });
  fresh->list = kdtree::CellList(std::move(ids));
  return fresh;
}

}  // namespace sightline::accel::lazy
