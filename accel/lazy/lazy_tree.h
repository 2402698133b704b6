// A kd-tree that grows where it is looked at. The part of the ray's way between "a cell is not
// built" and "it is".
#pragma once

#include <atomic>
#include <cstdint>

#include "accel/kdtree/kd_tree.h"
#include "accel/lazy/divide.h"

namespace sightline::accel::lazy {

/// What came of asking for a cell.
enum class ExpandResult : std::uint8_t {
  kRetry,     ///< There is something new in the slot: look again.
  kPending,   ///< A large cell, and others are at it: come back when they have got on.
  kScanList,  ///< Search the cell's list: others are at it, and it is small, or there is no memory.
};

/// What to do where others are at a large cell, once there is nothing left to help with.
enum class WhenPending : std::uint8_t {
  kReturn,  ///< Return kPending.
  kWait,    ///< Sleep until they have got on; if they seem to be stopped, do their work.
};

/// Threads: every member may be called from any thread at any time, pinned to an epoch (EpochPin).
/// A thread that is stopped in here, wherever it is, does not stop any other.
class LazyTree {
 public:
  /// `bounds` holds every reference; `primitive_count` is how many there are when all are opened,
  /// an upper bound. `mesh`: what the closed ones are faces of, for rules that clip; null if they
  /// are not. Must outlive the tree.
  LazyTree(const geometry::Aabb& bounds, std::size_t primitive_count, split::SplitRule rule,
           ReferenceSource source, const geometry::MeshView* mesh = nullptr);

  const kdtree::KdTree& tree() const { return tree_; }
  kdtree::AtomicSlot& root() { return tree_.root(); }

  /// Called by a ray that meets a deferred slot.
  ///
  /// First touch: one cell is divided (Division), and what comes of it is deferred. A cell of at
  /// most kEagerBelow triangles, by weight, is finished whole.
  ExpandResult expand(kdtree::AtomicSlot& slot, WhenPending when_pending,
                      kdtree::BuildCounters& counters);

  /// How far the expansion of a busy slot is; grows while there is progress.
  static std::uint64_t progress(const kdtree::AtomicSlot& slot);

  /// Expands everything until nothing is deferred but cells for which there was no room, or until
  /// `cancelled`. Parallel in the caller's arena.
  void expand_all(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled = nullptr);

 private:
  ExpandResult expand_now(kdtree::AtomicSlot& slot, WhenPending when_pending,
                          kdtree::BuildCounters& counters);
  ExpandResult wait_for_owner(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell,
                              WhenPending when_pending);
  ExpandResult expand_small(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                            kdtree::BuildCounters& counters);
  ExpandResult expand_large(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                            WhenPending when_pending, kdtree::BuildCounters& counters);
  ExpandResult run_all_passes(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, CellTask& task,
                              kdtree::BuildCounters& counters);
  kdtree::Slot make_slot(Division division, const kdtree::DeferredCell& cell);
  struct Shares;
  kdtree::Slot make_slot(Division& division, const SplitTree::Node& node, const Shares& shares);
  kdtree::Slot defer(ChildList part, const geometry::Aabb& box, const kdtree::CellPath& path);
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

  kdtree::KdTree tree_;
  split::SplitRule rule_;
  ReferenceSource source_;
  std::size_t primitive_count_;
  DivideContext context_;
};

/// A deferred cell this small is finished whole: splitting it further would cost more than it
/// defers.
inline constexpr std::size_t kEagerBelow = 64;

}  // namespace sightline::accel::lazy
