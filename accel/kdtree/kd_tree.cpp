// Storage of the kd-tree.
#include "accel/kdtree/kd_tree.h"

#include <algorithm>
#include <memory>

#include "accel/kdtree/epoch.h"

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace sightline::accel::kdtree {
namespace {

/// LeakSanitizer does not look for pointers in mapped memory unless it is told to: cells of a tree
/// that lives when the process ends would be leaks.
void expect_pointers(const ReservedArray<AtomicSlot>& pairs, bool lives) {
#ifdef __SANITIZE_ADDRESS__
  const std::size_t bytes = pairs.capacity() * sizeof(AtomicSlot);
  lives ? __lsan_register_root_region(pairs.data(), bytes)
        : __lsan_unregister_root_region(pairs.data(), bytes);
#else
  (void)pairs, (void)lives;
#endif
}

constexpr std::size_t kSpare = 64;

/// A share of a tree's bytes that does not matter.
constexpr std::uint64_t kRetiredBytesPerReference = 8;

void delete_cell(Retirable* retired) {
  auto* const cell = static_cast<DeferredCell*>(retired);
  cell->account->retired.fetch_sub(cell->size_in_bytes(), std::memory_order_relaxed);
  cell->account->free_retired(cell->size_in_bytes());
  delete cell;
}

void delete_subtree(Retirable* retired) {
  auto* const subtree = static_cast<FinishedSubtree*>(retired);
  subtree->account->free_retired(subtree->size_in_bytes());
  delete subtree;
}

/// That a cell waits, or no longer waits.
void count_waiting(const DeferredCell& cell, ListBytes& lists, bool waits) {
  const std::uint64_t bytes = waits ? cell.size_in_bytes() : -cell.size_in_bytes();  // wraps
  lists.deferred.fetch_add(bytes, std::memory_order_relaxed);
  lists.add(TreeBytes::kLists, bytes);
  if (cell.left_over) lists.left_over.fetch_add(bytes, std::memory_order_relaxed);
}

void delete_below(const KdTree& tree, Slot slot) {
  if (slot.is_deferred()) return delete slot.cell();
  if (slot.is_finished()) return delete slot.finished();
  if (!slot.is_binary()) return;
  const AtomicSlot* children = tree.children(slot);
  delete_below(tree, load(children[0]));
  delete_below(tree, load(children[1]));
}

}  // namespace

KdTree::KdTree(const geometry::Aabb& bounds, std::size_t references, const CellPath& path,
               std::shared_ptr<TreeMemory> memory)
    : bounds_(bounds),
      references_(references),
      root_(Slot::empty_leaf().bits()),
      free_soon_from_(references * kRetiredBytesPerReference) {
  lists_->memory = std::move(memory);
  if (references == 0) return;
  auto root = std::make_unique<DeferredCell>();
  root->box = bounds;
  root->path = path;
  root->has_list = false;
  root->size = references;
  root->weight = references;
  root_ = defer(std::move(root)).bits();
}

KdTree::~KdTree() {
  delete top_.load(std::memory_order_acquire);
  delete_below(*this, load(root_));
  if (const Arrays* arrays = arrays_.load(std::memory_order_acquire)) {
    expect_pointers(arrays->pairs, false);
    delete arrays;
  }
  lists_->add(TreeBytes::kLists, 0 - deferred_bytes());
  lists_->add(TreeBytes::kSubtrees, 0 - lists_->finished.load(std::memory_order_relaxed));
  use_pairs(0 - pairs());
  use_ids(0 - ids_used_.load(std::memory_order_relaxed));
}

/// The counts wrap around where fewer are used.
void KdTree::use_pairs(std::uint64_t pairs) {
  lists_->add(TreeBytes::kNodes, pairs * 2 * sizeof(AtomicSlot));
}
void KdTree::use_ids(std::uint64_t ids) {
  lists_->add(TreeBytes::kNodes, ids * sizeof(std::uint32_t));
}

void KdTree::reserve() {
  const std::size_t pairs =
      std::min<std::size_t>(references_ * capacity_.pairs + kSpare, Slot::kMaxPairs);
  const std::size_t ids =
      std::min<std::size_t>(references_ * capacity_.ids + kSpare, std::size_t{1} << 32);
  Arrays* arrays = arrays_.load(std::memory_order_acquire);
  if (arrays == nullptr) {
    auto fresh = std::make_unique<Arrays>(ReservedArray<AtomicSlot>(2 * pairs),
                                          ReservedArray<std::uint32_t>(ids));
    if (arrays_.compare_exchange_strong(arrays, fresh.get(), std::memory_order_acq_rel)) {
      arrays = fresh.release();
      expect_pointers(arrays->pairs, true);
    }
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
  use_pairs(1);
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
  use_ids(refs.size());
  std::uint32_t* ids = ids_.load(std::memory_order_relaxed) + first;
  for (std::size_t i = 0; i < refs.size(); ++i) ids[i] = refs[i].id;
  return Slot::leaf(refs.size(), static_cast<std::uint32_t>(first));
}

KdTree::NewNodes::NewNodes(KdTree& tree)
    : tree_(tree),
      alone_(tree.makers_.fetch_add(1) == 0),
      turn_(tree.turn_.fetch_add(1) + 1),
      pairs_(tree.pairs_used_.load()),
      ids_(tree.ids_used_.load()) {}

/// A thread that begins after the turn is read has made nothing if the counts are still the same.
KdTree::NewNodes::~NewNodes() {
  if (!kept_ && alone_) {
    std::uint64_t pairs = tree_.pairs_used_.load(), ids = tree_.ids_used_.load();
    if (tree_.turn_.load() == turn_) {
      if (tree_.pairs_used_.compare_exchange_strong(pairs, pairs_)) tree_.use_pairs(pairs_ - pairs);
      if (tree_.ids_used_.compare_exchange_strong(ids, ids_)) tree_.use_ids(ids_ - ids);
    }
  }
  tree_.makers_.fetch_sub(1);
}

Slot KdTree::defer(std::unique_ptr<DeferredCell> cell) {
  if (cell->size == 0) return Slot::empty_leaf();
  cell->account = lists_;
  count_waiting(*cell, *lists_, true);
  update_peak();
  return Slot::deferred(cell.release());
}

Slot KdTree::defer(ReferenceList list, const geometry::Aabb& box, const CellPath& path, Waits why) {
  auto cell = std::make_unique<DeferredCell>();
  cell->box = box;
  cell->path = path;
  cell->size = list.size();
  cell->weight = list.size();
  cell->list = CellList(std::move(list));
  cell->failed = why == Waits::kFailed;
  cell->left_over = why == Waits::kLeftOver;
  return defer(std::move(cell));
}

Slot KdTree::finish(std::unique_ptr<FinishedSubtree> subtree) {
  subtree->account = lists_;
  lists_->finished.fetch_add(subtree->size_in_bytes(), std::memory_order_relaxed);
  lists_->add(TreeBytes::kSubtrees, subtree->size_in_bytes());
  update_peak();
  return Slot::finished(subtree.release());
}

void KdTree::set_top(std::unique_ptr<FinishedSubtree> top) {
  top->account = lists_;
  lists_->finished.fetch_add(top->size_in_bytes(), std::memory_order_relaxed);
  lists_->add(TreeBytes::kSubtrees, top->size_in_bytes());
  FinishedSubtree* const before = top_.exchange(top.release(), std::memory_order_acq_rel);
  update_peak();
  if (before != nullptr) retire_subtree(*before);
}

void KdTree::retire_subtree(const FinishedSubtree& subtree) {
  const std::uint64_t bytes = subtree.size_in_bytes();
  lists_->finished.fetch_sub(bytes, std::memory_order_relaxed);
  lists_->retire(TreeBytes::kSubtrees, bytes);
  // It belongs to this tree, which made it.
  retire_for_walks(const_cast<FinishedSubtree&>(subtree), delete_subtree, bytes);
}

void KdTree::retire_cell(DeferredCell& cell) {
  const std::uint64_t bytes = cell.size_in_bytes();
  count_waiting(cell, *lists_, false);
  lists_->add(TreeBytes::kRetired, bytes);
  const std::uint64_t retired = lists_->retired.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  retire(cell, delete_cell, bytes, retired >= free_soon_from_);
}

void KdTree::add_growing(std::int64_t bytes) {
  if (bytes < 0) update_peak();  // nodes were added meanwhile
  // Two's complement: adding a negative number wraps to the right sum.
  lists_->growing.fetch_add(static_cast<std::uint64_t>(bytes), std::memory_order_relaxed);
  lists_->add(TreeBytes::kGrowing, static_cast<std::uint64_t>(bytes));
  if (bytes > 0) update_peak();
}

void KdTree::update_peak() {
  const std::uint64_t now = bytes() + lists_->retired.load(std::memory_order_relaxed) +
                            lists_->growing.load(std::memory_order_relaxed);
  std::uint64_t most = peak_.load(std::memory_order_relaxed);
  while (now > most && !peak_.compare_exchange_weak(most, now, std::memory_order_relaxed)) continue;
}

void KdTree::discard(Slot slot) {
  if (slot.is_deferred()) {
    count_waiting(*slot.cell(), *lists_, false);
    delete slot.cell();
    return;
  }
  if (slot.is_finished()) {
    lists_->finished.fetch_sub(slot.finished()->size_in_bytes(), std::memory_order_relaxed);
    lists_->add(TreeBytes::kSubtrees, 0 - slot.finished()->size_in_bytes());
    delete slot.finished();
    return;
  }
  if (!slot.is_binary()) return;
  AtomicSlot* pair = children(slot);
  discard(load(pair[0]));
  discard(load(pair[1]));
}

std::uint64_t KdTree::bytes() const {
  return lists_->deferred.load(std::memory_order_relaxed) +
         lists_->finished.load(std::memory_order_relaxed) +
         pairs_used_.load(std::memory_order_relaxed) * 2 * sizeof(AtomicSlot) +
         ids_used_.load(std::memory_order_relaxed) * sizeof(std::uint32_t);
}

}  // namespace sightline::accel::kdtree
