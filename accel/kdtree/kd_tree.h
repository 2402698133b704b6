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

/// Stores the nodes, cells and subtrees of a tree; it does not grow them. Threads: any thread that
/// is pinned to an epoch may read slots and follow them at any time.
class KdTree {
 public:
  /// Makes a tree of one deferred cell whose list is not made, or of an empty list if there are no
  /// references. `memory` counts its bytes with those of other trees; null if they are not counted
  /// there.
  KdTree(const geometry::Aabb& bounds, std::size_t references, const CellPath& path = {},
         std::shared_ptr<TreeMemory> memory = nullptr);
  ~KdTree();
  KdTree(const KdTree&) = delete;
  KdTree& operator=(const KdTree&) = delete;

  const geometry::Aabb& bounds() const { return bounds_; }
  AtomicSlot& root() { return root_; }
  const AtomicSlot& root() const { return root_; }

  /// Makes a node without children. It belongs to the tree once a slot leads to it; until then
  /// discard() frees it. Throws std::bad_alloc. Threads: any.
  WideNode* make_node();

  /// Returns the slot of a deferred cell, or of an empty list if the cell has no references.
  /// Threads: any.
  Slot defer(std::unique_ptr<DeferredCell> cell);
  /// Returns the slot of a cell that a cancelled build leaves (DeferredCell::left_over). Threads:
  /// any.
  Slot leave_over(ReferenceList list, const geometry::Aabb& box, const CellPath& path);

  /// Returns the slot of a finished subtree, which belongs to the tree from now on. Threads: any.
  Slot finish(std::unique_ptr<FinishedSubtree> subtree);

  /// Publishes `next`, which no other slot leads to, in place of `expected`, a deferred cell or a
  /// finished subtree, and retires that. Walks may use a subtree until they end, also after
  /// EpochPin::renew_for_cells(). Deferred cells count as waiting from here on, so those that two
  /// threads make for one slot never count twice. Returns false, and discards `next`, if the slot
  /// no longer holds `expected`. Threads: any.
  bool replace(AtomicSlot& slot, Slot expected, Slot next);
  /// Counts the tree's bytes with those of other trees; null if they are not counted there.
  TreeMemory* memory() const { return lists_->memory.get(); }

  /// Frees all at and below a slot that was never published. Threads: any.
  void discard(Slot slot);

  /// Bytes of nodes, finished subtrees, and deferred cells with their lists.
  std::uint64_t bytes() const;

  /// Bytes of deferred cells with their lists.
  std::uint64_t deferred_bytes() const { return at_least_0(lists_->deferred); }
  /// Bytes of finished subtrees.
  std::uint64_t finished_bytes() const { return lists_->finished.load(std::memory_order_relaxed); }
  /// Bytes of the deferred cells that cancelled builds left (DeferredCell::left_over).
  std::uint64_t left_over_bytes() const { return at_least_0(lists_->left_over); }
  /// The most bytes that the tree has held at any time: bytes(), retired cells, and the lists,
  /// blocks and cells that were being built.
  std::uint64_t bytes_peak() const { return peak_.load(std::memory_order_relaxed); }
  /// Adds to the bytes of lists and blocks of subtrees that are being built; negative when they are
  /// freed.
  void add_growing(std::int64_t bytes);

 private:
  /// A cell may be retired before the thread that published it has counted it.
  static std::uint64_t at_least_0(const std::atomic<std::uint64_t>& bytes) {
    const auto now = static_cast<std::int64_t>(bytes.load(std::memory_order_relaxed));
    return static_cast<std::uint64_t>(now > 0 ? now : 0);
  }
  struct WaitingBytes;
  void count_waiting(const WaitingBytes& bytes);
  void retire_cell(DeferredCell& cell);
  void retire_subtree(const FinishedSubtree& subtree);
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
