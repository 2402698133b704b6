// Storage of the kd-tree.
#include "accel/kdtree/kd_tree.h"

#include <algorithm>
#include <memory>

#include "accel/kdtree/epoch.h"

namespace sightline::accel::kdtree {
namespace {

// Far more than the surface area heuristic needs. A tree that needs more keeps its last cells
// deferred.
constexpr std::size_t kPairsPerReference = 32;
constexpr std::size_t kIdsPerReference = 64;
constexpr std::size_t kSpare = 64;

void delete_cell(Retirable* cell) { delete static_cast<DeferredCell*>(cell); }

void delete_cells(const KdTree& tree, Slot slot) {
  if (slot.is_deferred()) delete slot.cell();
  if (!slot.is_binary()) return;
  const AtomicSlot* children = tree.children(slot);
  delete_cells(tree, load(children[0]));
  delete_cells(tree, load(children[1]));
}

}  // namespace

KdTree::KdTree(const geometry::Aabb& bounds, std::size_t references, const CellPath& path)
    : bounds_(bounds), root_(Slot::empty_leaf().bits()) {
  if (references == 0) return;
  auto root = std::make_unique<DeferredCell>();
  root->box = bounds;
  root->path = path;
  root->has_list = false;
  root->size = references;
  root->weight = references;
  cell_bytes_ = root->size_in_bytes();
  root_ = Slot::deferred(root.release()).bits();
}

KdTree::~KdTree() {
  delete_cells(*this, load(root_));
  delete arrays_.load(std::memory_order_acquire);
}

void KdTree::reserve(std::size_t references) {
  const std::size_t pairs =
      std::min<std::size_t>(references * kPairsPerReference + kSpare, Slot::kMaxPairs);
  const std::size_t ids =
      std::min<std::size_t>(references * kIdsPerReference + kSpare, std::size_t{1} << 32);
  Arrays* arrays = arrays_.load(std::memory_order_acquire);
  if (arrays == nullptr) {
    auto fresh = std::make_unique<Arrays>(ReservedArray<AtomicSlot>(2 * pairs),
                                          ReservedArray<std::uint32_t>(ids));
    if (arrays_.compare_exchange_strong(arrays, fresh.get(), std::memory_order_acq_rel))
      arrays = fresh.release();
  }
  // Every thread stores them: the thread that made the arrays may be suspended before this line.
  pairs_.store(arrays->pairs.data(), std::memory_order_relaxed);
  ids_.store(arrays->ids.data(), std::memory_order_relaxed);
}

std::optional<std::uint32_t> KdTree::allocate_pair() {
  const Arrays* arrays = arrays_.load(std::memory_order_acquire);
  if (arrays == nullptr) return std::nullopt;
  const std::uint64_t pair = pairs_used_.fetch_add(1, std::memory_order_relaxed);
  if (2 * (pair + 1) > arrays->pairs.capacity()) {
    pairs_used_.fetch_sub(1, std::memory_order_relaxed);
    return std::nullopt;
  }
  return static_cast<std::uint32_t>(pair);
}

std::optional<Slot> KdTree::make_leaf(std::span<const Reference> refs) {
  if (refs.empty()) return Slot::empty_leaf();
  if (refs.size() == 1) return Slot::single(refs[0].id);
  if (refs.size() > Slot::kMaxLeafCount) return std::nullopt;
  const Arrays* arrays = arrays_.load(std::memory_order_acquire);
  if (arrays == nullptr) return std::nullopt;
  const std::uint64_t first = ids_used_.fetch_add(refs.size(), std::memory_order_relaxed);
  if (first + refs.size() > arrays->ids.capacity()) {
    ids_used_.fetch_sub(refs.size(), std::memory_order_relaxed);
    return std::nullopt;
  }
  std::uint32_t* ids = ids_.load(std::memory_order_relaxed) + first;
  for (std::size_t i = 0; i < refs.size(); ++i) ids[i] = refs[i].id;
  return Slot::leaf(refs.size(), static_cast<std::uint32_t>(first));
}

Slot KdTree::defer(std::unique_ptr<DeferredCell> cell) {
  if (cell->size == 0) return Slot::empty_leaf();
  cell_bytes_.fetch_add(cell->size_in_bytes(), std::memory_order_relaxed);
  return Slot::deferred(cell.release());
}

Slot KdTree::defer(ReferenceList list, const geometry::Aabb& box, const CellPath& path,
                   bool failed) {
  auto cell = std::make_unique<DeferredCell>();
  cell->box = box;
  cell->path = path;
  cell->size = list.size();
  cell->weight = list.size();
  cell->list = CellList(std::move(list));
  cell->failed = failed;
  return defer(std::move(cell));
}

void KdTree::retire_cell(DeferredCell& cell) {
  cell_bytes_.fetch_sub(cell.size_in_bytes(), std::memory_order_relaxed);
  retire(cell, delete_cell, cell.size_in_bytes());
}

void KdTree::discard(Slot slot) {
  if (slot.is_deferred()) {
    cell_bytes_.fetch_sub(slot.cell()->size_in_bytes(), std::memory_order_relaxed);
    delete slot.cell();
  }
  if (!slot.is_binary()) return;
  AtomicSlot* pair = children(slot);
  discard(load(pair[0]));
  discard(load(pair[1]));
}

std::uint64_t KdTree::bytes() const {
  return cell_bytes_.load(std::memory_order_relaxed) +
         pairs_used_.load(std::memory_order_relaxed) * 2 * sizeof(AtomicSlot) +
         ids_used_.load(std::memory_order_relaxed) * sizeof(std::uint32_t);
}

}  // namespace sightline::accel::kdtree
