// A kd-tree that grows where rays look: what happens between a ray's first step into a cell that is
// not built and the moment the cell is built.
#pragma once

#include <atomic>
#include <cstdint>

#include "accel/kdtree/kd_tree.h"
#include "accel/lazy/divide.h"

namespace sightline::accel::lazy {

/// The answer to a ray that asks for a cell.
enum class ExpandResult : std::uint8_t {
  kRetry,     ///< The slot has changed: read it again.
  kPending,   ///< Other threads expand a large cell: ask again when they have made progress.
  kScanList,  ///< Search the cell's list: another thread expands a small cell, or memory is short.
};

/// What to do when other threads expand a large cell and no work is left to help with.
enum class WhenPending : std::uint8_t {
  kReturn,  ///< Return kPending.
  kWait,    ///< Sleep until they have made progress; if they seem to be stopped, do their work.
};

/// Threads: every member may be called from any thread at any time, pinned to an epoch (EpochPin).
/// A thread that is stopped inside a member, at any point, does not stop any other.
class LazyTree {
 public:
  /// `bounds` contains every reference; `primitive_count` is an upper bound on their number when
  /// all are opened. `mesh`: the mesh whose faces they are, for rules that clip; null for other
  /// references. It must outlive the tree.
  LazyTree(const geometry::Aabb& bounds, std::size_t primitive_count, split::SplitRule rule,
           ReferenceSource source, const geometry::MeshView* mesh = nullptr);

  const kdtree::KdTree& tree() const { return tree_; }
  kdtree::AtomicSlot& root() { return tree_.root(); }

  /// Called by a ray that meets a deferred slot.
  ///
  /// First touch: one cell is divided (Division), and the new cells are deferred. The subtree of a
  /// cell of at most kEagerBelow triangles, by weight, is built at once.
  ///
  /// Once `cancelled` is true, a thread leaves a large cell after a slice of it, with kScanList.
  /// What is done of the cell remains for the next ray.
  ExpandResult expand(kdtree::AtomicSlot& slot, WhenPending when_pending,
                      kdtree::BuildCounters& counters,
                      const std::atomic<bool>* cancelled = nullptr);

  /// Measures the progress of a busy slot's expansion: grows while threads work on it.
  static std::uint64_t progress(const kdtree::AtomicSlot& slot);

  /// Expands all cells until only those without room are deferred, or until `cancelled` is set.
  /// Parallel in the caller's arena.
  void expand_all(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled = nullptr);

  /// Whether expand_all() has found nothing left to expand, not even cells without room. Then it
  /// returns at once.
  bool is_complete() const { return complete_.load(std::memory_order_acquire); }

 private:
  ExpandResult expand_now(kdtree::AtomicSlot& slot, WhenPending when_pending,
                          kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);
  ExpandResult wait_for_owner(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell,
                              WhenPending when_pending);
  ExpandResult expand_small(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                            kdtree::BuildCounters& counters);
  ExpandResult expand_large(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                            WhenPending when_pending, kdtree::BuildCounters& counters,
                            const std::atomic<bool>* cancelled);
  ExpandResult run_all_passes(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, CellTask& task,
                              kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);
  kdtree::Slot make_slot(Division division, const kdtree::DeferredCell& cell);
  kdtree::Slot make_slot(Division& division, const SplitTree::Node& node);
  kdtree::Slot defer(NewCell now);
  kdtree::Slot finish(const kdtree::DeferredCell& cell, kdtree::BuildCounters& counters,
                      const std::atomic<bool>* cancelled);
  void complete(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                const std::atomic<bool>* cancelled);
  void complete_cell(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                     kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);
  bool claim(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell);
  void release_claim(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell);
  void publish(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, kdtree::Slot built,
               kdtree::BuildCounters& counters);
  void count(const kdtree::AtomicSlot& slot, kdtree::Slot built, kdtree::BuildCounters& counters);

  kdtree::KdTree tree_;
  split::SplitRule rule_;
  ReferenceSource source_;
  std::size_t primitive_count_;
  DivideContext context_;
  std::atomic<bool> complete_{false};
};

/// The subtree of a deferred cell of at most this weight is built at once: dividing it cell by cell
/// would cost more work than it defers.
inline constexpr std::size_t kEagerBelow = 64;

}  // namespace sightline::accel::lazy
