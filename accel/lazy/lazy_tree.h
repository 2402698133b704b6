// A kd-tree that grows where it is looked at. The part of the ray's way between "a cell is not
// built" and "it is".
#pragma once

#include <atomic>
#include <cstdint>

#include "accel/kdtree/kd_tree.h"
#include "accel/lazy/divide.h"

namespace sightline::accel::lazy {

/// What came of asking for a cell.
enum class Expanded : std::uint8_t {
  kAgain,   ///< There is something new in the slot: look again.
  kBusy,    ///< A large cell, and others are at it: come back when they have got on.
  kSearch,  ///< Search the cell's list: others are at it, and it is small, or there is no memory.
};

/// What to do where others are at a large cell, once there is nothing left to help with.
enum class AtBusy : std::uint8_t {
  kLeave,  ///< Return kBusy.
  kWait,   ///< Sleep until they have got on; if they seem to be stopped, do their work.
};

/// Threads: every member may be called from any thread at any time, pinned to an epoch (EpochPin).
/// A thread that is stopped in here, wherever it is, does not stop any other.
class LazyTree {
 public:
  /// `bounds` holds every reference; `closed` is how many there are when all are opened, an upper
  /// bound. `mesh`: what the closed ones are faces of, for rules that clip; null if they are
  /// not. Must outlive the tree.
  LazyTree(const geometry::Aabb& bounds, std::size_t closed, split::SplitRule rule,
           ReferenceSource source, const geometry::MeshView* mesh = nullptr);

  const kdtree::KdTree& tree() const { return tree_; }
  kdtree::AtomicSlot& root() { return tree_.root(); }

  /// Called by a ray that meets an unbuilt slot.
  ///
  /// First touch: one cell is divided (Division), and what comes of it is deferred. A cell of at
  /// most kFinishBelow triangles, by weight, is finished whole.
  Expanded expand(kdtree::AtomicSlot& slot, AtBusy at_busy, kdtree::BuildCounters& counters);

  /// How far the expansion of a busy slot is; grows while there is progress.
  static std::uint64_t progress(const kdtree::AtomicSlot& slot);

  /// Expands everything until nothing is unbuilt but cells for which there was no room, or until
  /// `cancelled`. Parallel in the caller's arena.
  void expand_all(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled = nullptr);

 private:
  Expanded expand_now(kdtree::AtomicSlot& slot, AtBusy at_busy, kdtree::BuildCounters& counters);
  Expanded meet_claimed(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell, AtBusy at_busy);
  Expanded expand_small(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                        kdtree::BuildCounters& counters);
  Expanded expand_large(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, AtBusy at_busy,
                        kdtree::BuildCounters& counters);
  Expanded lead(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, Expansion& expansion,
                kdtree::BuildCounters& counters);
  kdtree::Slot make_slot(Division division, const kdtree::DeferredCell& cell);
  kdtree::Slot make_slot(Division& division, const CutTree::Node& node);
  kdtree::Slot defer(NewCell now);
  kdtree::Slot finish(const kdtree::DeferredCell& cell, kdtree::BuildCounters& counters,
                      const std::atomic<bool>* cancelled);
  void complete(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                const std::atomic<bool>* cancelled);
  void complete_cell(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                     kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);
  bool claim(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell);
  void give_back(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell);
  void publish(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, kdtree::Slot built,
               kdtree::BuildCounters& counters);

  kdtree::KdTree tree_;
  split::SplitRule rule_;
  ReferenceSource source_;
  std::size_t closed_;
  DivideContext context_;
};

/// A deferred cell this small is finished whole: splitting it further would cost more than it
/// defers.
inline constexpr std::size_t kFinishBelow = 64;

}  // namespace sightline::accel::lazy
