// A kd-tree that grows where it is looked at. The part of the ray's way between "a cell is not
// built" and "it is".
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "accel/build/any_builder.h"
#include "accel/build/grow.h"
#include "accel/tree/deferred_cell.h"
#include "accel/tree/kd_tree.h"

namespace sightline::accel {

/// All references of a tree, made from its geometry. Called when the root is expanded, by one
/// thread.
using ReferenceSource = std::function<BoxList(BuildCounters&)>;

/// Threads: every member may be called from any thread at any time, pinned to an epoch (EpochPin).
class LazyTree {
 public:
  /// `bounds` holds every reference; `references` is how many the source will make (an upper
  /// bound). `mesh`: what the references are faces of, for builders that clip; null if they are
  /// not. Must outlive the tree.
  LazyTree(const Aabb& bounds, std::size_t references, const AnyBuilder& builder,
           ReferenceSource source, const MeshView* mesh = nullptr);

  const KdTree& tree() const { return tree_; }
  AtomicSlot& root() { return tree_.root(); }

  /// Called by a ray that meets an unbuilt slot. True: the slot is built now (by us, or by the work
  /// we joined), read it again. False: somebody is at it and it is small, or there is no memory:
  /// search the cell's list instead.
  ///
  /// First touch: one cell is cut into two deferred ones. A cell of at most kFinishBelow references
  /// is finished whole.
  bool expand(AtomicSlot& slot, BuildCounters& counters);

  /// Expands everything until nothing is unbuilt but cells for which there was no room, or until
  /// `cancelled`. Parallel in the caller's arena.
  void expand_all(BuildCounters& counters, const std::atomic<bool>* cancelled = nullptr);

 private:
  enum class Extent { kOneCell, kSubtree };

  bool claim_and_build(AtomicSlot& slot, DeferredCell& cell, Extent extent, BuildCounters& counters,
                       const std::atomic<bool>* cancelled);
  bool build(AtomicSlot& slot, DeferredCell& cell, Extent extent, BuildCounters& counters,
             const std::atomic<bool>* cancelled);
  Slot cut_once(std::span<const BoxRef> refs, const DeferredCell& cell, BuildCounters& counters);
  Slot finish(BoxList list, const DeferredCell& cell, BuildCounters& counters,
              const std::atomic<bool>* cancelled);
  void expand_rounds(BuildCounters& counters, const std::atomic<bool>* cancelled);
  void finish_slot(AtomicSlot& slot, BuildCounters& counters, const std::atomic<bool>* cancelled);

  KdTree tree_;
  AnyBuilder builder_;
  ReferenceSource source_;
  const MeshView* mesh_;
  std::size_t references_;
  int max_depth_;
};

/// A deferred cell this small is finished whole: splitting it further would cost more than it
/// defers.
inline constexpr std::size_t kFinishBelow = 32;

}  // namespace sightline::accel
