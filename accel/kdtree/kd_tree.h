// The one kd-tree: slots, pairs of slots, and the ids its leaves hold. Grows at its deferred slots
// while it is read.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/kdtree/deferred_cell.h"
#include "accel/kdtree/reserved_array.h"
#include "accel/kdtree/slot.h"

namespace sightline::accel::kdtree {

using AtomicSlot = std::atomic<std::uint64_t>;

inline Slot load(const AtomicSlot& slot) { return Slot(slot.load(std::memory_order_acquire)); }

/// Deepest node of any tree: walks keep a stack of this size.
inline constexpr int kMaxTreeDepth = 80;

/// Storage only: what a slot says may be followed at any time by any thread that is pinned to an
/// epoch.
class KdTree {
 public:
  /// A tree that is one cell, not listed yet; an empty leaf for no references.
  KdTree(const geometry::Aabb& bounds, std::size_t references, const CellPath& path = {});
  ~KdTree();
  KdTree(const KdTree&) = delete;
  KdTree& operator=(const KdTree&) = delete;

  const geometry::Aabb& bounds() const { return bounds_; }
  AtomicSlot& root() { return root_; }
  const AtomicSlot& root() const { return root_; }

  /// The two child slots of a binary slot, left first.
  AtomicSlot* children(Slot binary) const {
    return pairs_.load(std::memory_order_relaxed) + 2 * std::size_t{binary.pair()};
  }

  /// The references of a leaf slot. `storage` backs the span where the leaf holds its one reference
  /// itself.
  std::span<const std::uint32_t> leaf(Slot slot, std::uint32_t& storage) const {
    if (slot.leaf_count() == 1) {
      storage = slot.leaf_first();
      return {&storage, 1};
    }
    return {ids_.load(std::memory_order_relaxed) + slot.leaf_first(), slot.leaf_count()};
  }

  /// Makes room for a tree over `references` boxes, if nobody has. To be called by every thread
  /// before it makes its first node. Throws std::bad_alloc. Threads: any.
  void reserve(std::size_t references);

  /// The place of a fresh pair of slots, or nothing if the reservation is used up. Threads: any.
  std::optional<std::uint32_t> allocate_pair();

  /// A leaf over these references, or nothing if the reservation is used up. Threads: any.
  std::optional<Slot> make_leaf(std::span<const Reference> refs);

  /// A slot to be expanded later, whose list is made already; an empty leaf if that is empty.
  /// Threads: any.
  Slot defer(std::unique_ptr<DeferredCell> cell);
  Slot defer(ReferenceList list, const geometry::Aabb& box, const CellPath& path,
             bool failed = false);

  /// Hands a deferred cell, which no slot leads to any more, over to the epoch. Threads: any.
  void retire_cell(DeferredCell& cell);

  /// Frees the deferred cells at and below a slot that was never published.
  void discard(Slot slot);

  /// Nodes, ids and deferred cells with their lists.
  std::uint64_t bytes() const;

 private:
  struct Arrays {
    ReservedArray<AtomicSlot> pairs;
    ReservedArray<std::uint32_t> ids;
  };

  geometry::Aabb bounds_;
  AtomicSlot root_;
  std::atomic<Arrays*> arrays_{nullptr};
  // The same, nearer to the walk.
  std::atomic<AtomicSlot*> pairs_{nullptr};
  std::atomic<std::uint32_t*> ids_{nullptr};
  // Written by every growing thread: not on the lines that walks read, nor on each other's.
  alignas(64) std::atomic<std::uint64_t> pairs_used_{0};
  alignas(64) std::atomic<std::uint64_t> ids_used_{0};
  alignas(64) std::atomic<std::uint64_t> cell_bytes_{0};
};

}  // namespace sightline::accel::kdtree
