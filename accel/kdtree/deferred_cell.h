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
  std::atomic<std::uint64_t> deferred{0};  ///< Deferred cells that are published, with their lists.
  /// The part of `deferred` that is DeferredCell::left_over.
  std::atomic<std::uint64_t> left_over{0};
  std::atomic<std::uint64_t> retired{0};  ///< Retired cells that are not freed yet.
  /// Lists and blocks of subtrees that are being built, and cells that are not published yet.
  std::atomic<std::uint64_t> growing{0};
  std::atomic<std::uint64_t> finished{0};  ///< Finished subtrees.
  /// Counts these bytes with those of other trees; null if they are not counted there.
  std::shared_ptr<TreeMemory> memory{};

  void add(TreeBytes kind, std::uint64_t bytes) const {
    if (memory != nullptr) memory->add(kind, bytes);
  }
  void move(TreeBytes from, TreeBytes to, std::uint64_t bytes) const {
    if (memory != nullptr) memory->move(from, to, bytes);
  }
  void free_retired(std::uint64_t bytes) const { add(TreeBytes::kRetired, 0 - bytes); }
};

/// A cell that is not built. Immutable except for the atomics, until it is retired. Readers are
/// pinned to an epoch.
struct alignas(16) DeferredCell : Retirable {
  DeferredCell() = default;
  DeferredCell(const DeferredCell&) = delete;
  DeferredCell& operator=(const DeferredCell&) = delete;
  ~DeferredCell() {
    if (RefCounted* shared = passes.load(std::memory_order_acquire)) shared->leave();
  }

  geometry::Aabb box;
  CellPath path;
  /// Whether `list` is made. The root's list is made from the geometry when the root is expanded;
  /// until then readers search all of the geometry.
  bool has_list = true;
  /// Whether references of the list may be openable.
  bool openable = false;
  bool left_over = false;  ///< Whether a cancelled build of a subtree left the cell.
  /// Whether its subtree is built at once, as the lists of its cells would take too much memory.
  bool whole = false;
  /// Whether it was built and then evicted (lazy/eviction.h): rays pay for building it again first.
  bool evicted = false;
  CellList list;
  std::size_t size = 0;      ///< References in the cell, also if the list is not made.
  std::uint64_t weight = 0;  ///< Sum of the weights of all references.
  ChildScan first;  ///< Counts of the first pass, if they were made when the list was written.
  /// What searches of the list have cost rays, in the unit of accel/lazy/demand_costs.h.
  mutable std::atomic<std::uint64_t> spent{0};
  LastUse last_use;  ///< The last search of the list.
  /// Set once a thread has begun to expand a large cell: the passes that threads share
  /// (accel/lazy/passes.h).
  std::atomic<RefCounted*> passes{nullptr};
  std::shared_ptr<ListBytes> account;  ///< The bytes of its tree.

  std::uint64_t size_in_bytes() const { return sizeof(DeferredCell) + list.bytes(); }
};

/// The same references at the same place, and what rays have spent on them. Throws std::bad_alloc.
inline std::unique_ptr<DeferredCell> copy_without_list(const DeferredCell& cell) {
  auto copy = std::make_unique<DeferredCell>();
  copy->box = cell.box;
  copy->path = cell.path;
  copy->openable = cell.openable;
  copy->left_over = cell.left_over;
  copy->size = cell.size;
  copy->weight = cell.weight;
  copy->spent = cell.spent.load(std::memory_order_relaxed);
  return copy;
}

}  // namespace sightline::accel::kdtree
