// A kd-tree that grows where it is looked at. The part of the ray's way between "a cell is not
// built" and "it is".
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "accel/build/any_builder.h"
#include "accel/build/grow.h"
#include "accel/tree/deferred_cell.h"
#include "accel/tree/kd_tree.h"

namespace sightline::accel {

/// Where a tree's references come from. Threads: both functions, any, several at once.
struct ReferenceSource {
  /// The coarsest ones, all together: what the root is expanded from. Always the same.
  std::function<BoxList(BuildCounters&)> list;
  /// Appends what an openable reference stands for, openable ones among it or not. Their boxes lie
  /// within its own. The same reference always opens into the same ones. Null: none is openable.
  std::function<void(const BoxRef&, std::vector<BoxRef>&)> open;
};

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
