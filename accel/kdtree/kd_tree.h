// Storage of a tree: its nodes, and the cells and subtrees below them. Slots are replaced while
// other threads read the tree.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "accel/geometry/aabb.h"
#include "accel/kdtree/deferred_cell.h"
#include "accel/kdtree/finished_subtree.h"
#include "accel/kdtree/slot.h"
#include "accel/kdtree/wide_node.h"

namespace sightline::accel::kdtree {

/// Largest depth of a cell in any tree.
inline constexpr int kMaxTreeDepth = 80;

/// Storage only. Threads: any thread that is pinned to an epoch may read slots and follow them at
/// any time.
class KdTree {
 public:
  /// A tree of one deferred cell whose list is not made; of an empty list if there are no
  /// references. `memory`: counts its bytes with those of other trees; null: they are not counted.
  KdTree(const geometry::Aabb& bounds, std::size_t references, const CellPath& path = {},
         std::shared_ptr<TreeMemory> memory = nullptr);
  ~KdTree();
  KdTree(const KdTree&) = delete;
  KdTree& operator=(const KdTree&) = delete;

  const geometry::Aabb& bounds() const { return bounds_; }
  AtomicSlot& root() { return root_; }
  const AtomicSlot& root() const { return root_; }

  /// A node without children, which belongs to the tree once a slot leads to it; until then
  /// discard() frees it. Throws std::bad_alloc. Threads: any.
  WideNode* make_node();

  /// A deferred slot whose list is made; an empty list if there is nothing in it. Threads: any.
  Slot defer(std::unique_ptr<DeferredCell> cell);
  /// As above, for what a cancelled build leaves (DeferredCell::left_over).
  Slot leave_over(ReferenceList list, const geometry::Aabb& box, const CellPath& path);

  /// The slot of a finished subtree, which belongs to the tree from now on. Threads: any.
  Slot finish(std::unique_ptr<FinishedSubtree> subtree);

  /// Retires a deferred cell that no slot refers to any more. Threads: any.
  void retire_cell(DeferredCell& cell);
  /// As above, a finished subtree, for walks that go on with renewed pins, too.
  void retire_subtree(const FinishedSubtree& subtree);
  /// Null: its bytes are not counted with those of other trees.
  TreeMemory* memory() const { return lists_->memory.get(); }

  /// Frees all at and below a slot that was never published.
  void discard(Slot slot);

  /// Bytes of nodes, finished subtrees, and deferred cells with their lists.
  std::uint64_t bytes() const;

  /// Bytes of deferred cells with their lists.
  std::uint64_t deferred_bytes() const { return lists_->deferred.load(std::memory_order_relaxed); }
  /// Bytes of finished subtrees.
  std::uint64_t finished_bytes() const { return lists_->finished.load(std::memory_order_relaxed); }
  /// Those that cancelled builds left (DeferredCell::left_over).
  std::uint64_t left_over_bytes() const {
    return lists_->left_over.load(std::memory_order_relaxed);
  }
  /// The most bytes that the tree has held at any time: bytes(), retired cells, and the lists of
  /// subtrees that were being built.
  std::uint64_t bytes_peak() const { return peak_.load(std::memory_order_relaxed); }
  /// Adds to the lists of subtrees that are being built; negative: when they are freed.
  void add_growing(std::int64_t bytes);

 private:
  void update_peak();
  void use_nodes(std::int64_t nodes);

  geometry::Aabb bounds_;
  AtomicSlot root_{0};
  std::shared_ptr<ListBytes> lists_ = std::make_shared<ListBytes>();
  std::atomic<std::uint64_t> nodes_{0};
  std::atomic<std::uint64_t> peak_{0};
  /// Retired bytes from which on they are freed as soon as the thread leaves its pin.
  std::uint64_t free_soon_from_;
};

}  // namespace sightline::accel::kdtree
