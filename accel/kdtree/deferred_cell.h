// A cell that is not built yet: its box, its list, and the work that threads share to build it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/last_use.h"
#include "accel/kdtree/plane_counts.h"
#include "accel/kdtree/ref_counted.h"
#include "accel/kdtree/reference_list.h"
#include "accel/kdtree/tree_memory.h"

namespace sightline::accel::kdtree {

/// The bytes of a tree's cells, lists and finished subtrees. Cells share it with their tree,
/// because retired ones may outlive it.
struct ListBytes {
  std::atomic<std::uint64_t> deferred{0};   ///< Deferred cells with their lists.
  std::atomic<std::uint64_t> left_over{0};  ///< Of those, DeferredCell::left_over.
  std::atomic<std::uint64_t> retired{0};    ///< Retired cells that are not freed yet.
  std::atomic<std::uint64_t> growing{0};    ///< Lists of the subtrees that are built at once.
  std::atomic<std::uint64_t> finished{0};   ///< Finished subtrees.
  /// What the tree adds its bytes to; null: nothing.
  std::shared_ptr<TreeMemory> memory{};

  void add(TreeBytes kind, std::uint64_t bytes) const {
    if (memory != nullptr) memory->add(kind, bytes);
  }
  void retire(TreeBytes kind, std::uint64_t bytes) const {
    if (memory != nullptr) memory->move(kind, TreeBytes::kRetired, bytes);
  }
  void free_retired(std::uint64_t bytes) const { add(TreeBytes::kRetired, 0 - bytes); }
};

/// Immutable except for the atomics, until it is retired. Readers are pinned to an epoch.
struct alignas(16) DeferredCell : Retirable {
  DeferredCell() = default;
  DeferredCell(const DeferredCell&) = delete;
  DeferredCell& operator=(const DeferredCell&) = delete;
  ~DeferredCell() {
    if (RefCounted* work = task.load(std::memory_order_acquire)) work->leave();
  }

  geometry::Aabb box;
  CellPath path;
  /// Whether `list` is made. The root's list is made from the geometry when the root is expanded;
  /// until then readers search all of the geometry.
  bool has_list = true;
  /// Some references of the list may be openable.
  bool openable = false;
  bool left_over = false;  ///< By a subtree that was being built at once and was cancelled.
  bool whole = false;      ///< Its subtree is built at once: lists for later would take too much.
  /// It was built, and had to go (lazy/eviction.h): rays pay for building it again first.
  bool evicted = false;
  CellList list;
  std::size_t size = 0;      ///< References in the cell, also if the list is not made.
  std::uint64_t weight = 0;  ///< Sum over all references.
  ChildScan first;  ///< Counts of the first pass, if they were made when the list was written.
  /// What rays have spent on searching the list, or will before they go on: references read.
  mutable std::atomic<std::uint64_t> spent{0};
  LastUse last_use;  ///< By rays that searched the list.
  /// Set once a thread has begun to expand a large cell: the work that threads share
  /// (accel/lazy/cell_task.h).
  std::atomic<RefCounted*> task{nullptr};
  std::shared_ptr<ListBytes> account;  ///< Of its tree.

  std::uint64_t size_in_bytes() const { return sizeof(DeferredCell) + list.bytes(); }
};

}  // namespace sightline::accel::kdtree
