// Storage of the kd-tree.
#include "accel/kdtree/kd_tree.h"

#include <algorithm>
#include <memory>

#include "accel/kdtree/epoch.h"

namespace sightline::accel::kdtree {
namespace {

/// Retired bytes that may wait for each reference: a small share of a tree's bytes.
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

}  // namespace

/// The bytes of all deferred cells at and below a slot.
struct KdTree::WaitingBytes {
  explicit WaitingBytes(Slot slot) {
    if (slot.is_deferred()) {
      all = slot.cell()->size_in_bytes();
      left_over = slot.cell()->left_over ? all : 0;
    } else if (slot.is_node()) {
      for (const AtomicSlot& child : slot.node()->children) {
        const WaitingBytes below(load(child));
        all += below.all;
        left_over += below.left_over;
      }
    }
  }
  std::uint64_t all = 0, left_over = 0;
};

KdTree::KdTree(const geometry::Aabb& bounds, std::size_t references, const CellPath& path,
               std::shared_ptr<TreeMemory> memory)
    : bounds_(bounds), free_soon_from_(references * kRetiredBytesPerReference) {
  lists_->memory = std::move(memory);
  auto root = std::make_unique<DeferredCell>();
  root->box = bounds;
  root->path = path;
  root->has_list = false;
  root->size = references;
  root->weight = references;
  root_ = defer(std::move(root)).bits();
  count_waiting(WaitingBytes(load(root_)));
}

KdTree::~KdTree() {
  lists_->move(TreeBytes::kLists, TreeBytes::kGrowing, WaitingBytes(load(root_)).all);
  discard(load(root_));
}

/// The bytes are added once they are taken from those that grow, so that no peak has them twice.
void KdTree::count_waiting(const WaitingBytes& bytes) {
  lists_->growing.fetch_sub(bytes.all, std::memory_order_relaxed);
  lists_->deferred.fetch_add(bytes.all, std::memory_order_relaxed);
  lists_->left_over.fetch_add(bytes.left_over, std::memory_order_relaxed);
  lists_->move(TreeBytes::kGrowing, TreeBytes::kLists, bytes.all);
}

bool KdTree::replace(AtomicSlot& slot, Slot expected, Slot next) {
  const WaitingBytes waiting(next);  // other threads may replace the cells once they see them
  std::uint64_t bits = expected.bits();
  if (!slot.compare_exchange_strong(bits, next.bits(), std::memory_order_acq_rel)) {
    discard(next);
    return false;
  }
  count_waiting(waiting);
  if (expected.is_deferred()) {
    retire_cell(*expected.cell());
  } else {
    retire_subtree(*expected.finished());
  }
  return true;
}

WideNode* KdTree::make_node() {
  auto* const node = new WideNode;
  use_nodes(1);
  return node;
}

void KdTree::use_nodes(std::int64_t nodes) {
  // Two's complement: adding a negative number wraps to the right sum.
  nodes_.fetch_add(static_cast<std::uint64_t>(nodes), std::memory_order_relaxed);
  lists_->add(TreeBytes::kNodes, static_cast<std::uint64_t>(nodes) * sizeof(WideNode));
}

Slot KdTree::defer(std::unique_ptr<DeferredCell> cell) {
  if (cell->size == 0) return Slot::empty_list();
  cell->account = lists_;
  add_growing(static_cast<std::int64_t>(cell->size_in_bytes()));
  return Slot::deferred(cell.release());
}

Slot KdTree::leave_over(ReferenceList list, const geometry::Aabb& box, const CellPath& path) {
  auto cell = std::make_unique<DeferredCell>();
  cell->box = box;
  cell->path = path;
  cell->size = list.size();
  cell->weight = list.size();
  cell->list = CellList(std::move(list));
  cell->left_over = true;
  return defer(std::move(cell));
}

Slot KdTree::finish(std::unique_ptr<FinishedSubtree> subtree) {
  subtree->account = lists_;
  lists_->finished.fetch_add(subtree->size_in_bytes(), std::memory_order_relaxed);
  lists_->add(TreeBytes::kSubtrees, subtree->size_in_bytes());
  update_peak();
  return Slot::finished(subtree.release());
}

void KdTree::retire_subtree(const FinishedSubtree& subtree) {
  const std::uint64_t bytes = subtree.size_in_bytes();
  lists_->finished.fetch_sub(bytes, std::memory_order_relaxed);
  lists_->move(TreeBytes::kSubtrees, TreeBytes::kRetired, bytes);
  // The subtree belongs to this tree, which may change it.
  retire_for_walks(const_cast<FinishedSubtree&>(subtree), delete_subtree, bytes);
}

void KdTree::retire_cell(DeferredCell& cell) {
  const std::uint64_t bytes = cell.size_in_bytes();
  lists_->deferred.fetch_sub(bytes, std::memory_order_relaxed);
  if (cell.left_over) lists_->left_over.fetch_sub(bytes, std::memory_order_relaxed);
  lists_->move(TreeBytes::kLists, TreeBytes::kRetired, bytes);
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
    add_growing(-static_cast<std::int64_t>(slot.cell()->size_in_bytes()));
    delete slot.cell();
  } else if (slot.is_finished()) {
    lists_->finished.fetch_sub(slot.finished()->size_in_bytes(), std::memory_order_relaxed);
    lists_->add(TreeBytes::kSubtrees, 0 - slot.finished()->size_in_bytes());
    delete slot.finished();
  } else if (slot.is_node()) {
    for (const AtomicSlot& child : slot.node()->children) discard(load(child));
    delete slot.node();
    use_nodes(-1);
  }
}

std::uint64_t KdTree::bytes() const {
  return deferred_bytes() + lists_->finished.load(std::memory_order_relaxed) +
         nodes_.load(std::memory_order_relaxed) * sizeof(WideNode);
}

}  // namespace sightline::accel::kdtree
