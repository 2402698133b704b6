// Storage of a kd-tree: slots, pairs of slots, and the ids in its leaves. Deferred slots are
// replaced while other threads read the tree.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/kdtree/deferred_cell.h"
#include "accel/kdtree/finished_subtree.h"
#include "accel/kdtree/reserved_array.h"
#include "accel/kdtree/slot.h"

namespace sightline::accel::kdtree {

using AtomicSlot = std::atomic<std::uint64_t>;

inline Slot load(const AtomicSlot& slot) { return Slot(slot.load(std::memory_order_acquire)); }

/// Largest depth of a node in any tree: traversals keep a stack of this size.
inline constexpr int kMaxTreeDepth = 80;

/// Storage only. Threads: any thread that is pinned to an epoch may read slots and follow them at
/// any time.
class KdTree {
 public:
  /// A tree of one deferred cell whose list is not made; of one empty leaf if there are no
  /// references.
  /// `memory`: counts its bytes with those of other trees; null: they are not counted.
  KdTree(const geometry::Aabb& bounds, std::size_t references, const CellPath& path = {},
         std::shared_ptr<TreeMemory> memory = nullptr);
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

  /// The references of a leaf slot. If the slot itself holds the only one, the span points to
  /// `storage`.
  std::span<const std::uint32_t> leaf(Slot slot, std::uint32_t& storage) const {
    if (slot.leaf_count() == 1) {
      storage = slot.leaf_first();
      return {&storage, 1};
    }
    return {ids_.load(std::memory_order_relaxed) + slot.leaf_first(), slot.leaf_count()};
  }

  /// Most pairs and ids that the arrays can hold for each reference of the root, beside a few.
  struct Capacity {
    std::size_t pairs = 32, ids = 64;
  };

  /// How much reserve() makes room for. To be called before other threads see the tree.
  void set_capacity(const Capacity& capacity) { capacity_ = capacity; }
  /// Makes the arrays, once: a tree that is one finished subtree needs none. Every thread calls it
  /// before it makes its first pair or leaf. Throws std::bad_alloc. Threads: any.
  void reserve();

  /// Index of a new pair of slots, or nothing if the array is full or not reserved. Threads: any.
  std::optional<std::uint32_t> allocate_pair();

  /// A leaf over these references, or nothing if the array of ids is full or not reserved.
  /// Threads: any.
  std::optional<Slot> make_leaf(std::span<const Reference> refs);

  /// A deferred slot whose list is made; an empty leaf if the list is empty. Threads: any.
  Slot defer(std::unique_ptr<DeferredCell> cell);
  enum class Waits : std::uint8_t { kForRays, kLeftOver, kFailed };  ///< See DeferredCell.
  Slot defer(ReferenceList list, const geometry::Aabb& box, const CellPath& path,
             Waits why = Waits::kForRays);

  /// The slot of a finished subtree, which belongs to the tree from now on. Threads: any.
  Slot finish(std::unique_ptr<FinishedSubtree> subtree);

  /// A second form of the nodes near the root, for traversals; null: there is none. It leads to
  /// slots and finished subtrees of this tree. Replaced ones are retired. Threads: any, pinned.
  const FinishedSubtree* top() const { return top_.load(std::memory_order_acquire); }
  void set_top(std::unique_ptr<FinishedSubtree> top);

  /// Pairs of slots made so far.
  std::uint64_t pairs() const { return pairs_used_.load(std::memory_order_relaxed); }

  /// Retires a deferred cell that no slot refers to any more. Threads: any.
  void retire_cell(DeferredCell& cell);
  /// As above, a finished subtree, for walks that go on with renewed pins, too.
  void retire_subtree(const FinishedSubtree& subtree);
  /// Null: its bytes are not counted with those of other trees.
  TreeMemory* memory() const { return lists_->memory.get(); }

  /// Frees the deferred cells and finished subtrees at and below a slot that was never published.
  void discard(Slot slot);

  /// The nodes and leaves that a thread, and those that help it, make while this lives. Unless they
  /// are kept, they are given back; not if another thread makes some at the same time.
  class NewNodes {
   public:
    explicit NewNodes(KdTree& tree);
    ~NewNodes();
    NewNodes(const NewNodes&) = delete;
    NewNodes& operator=(const NewNodes&) = delete;
    void keep() { kept_ = true; }

   private:
    KdTree& tree_;
    const bool alone_;
    const std::uint64_t turn_;
    const std::uint64_t pairs_, ids_;
    bool kept_ = false;
  };

  /// Bytes of nodes, ids, finished subtrees, and deferred cells with their lists.
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
  void use_pairs(std::uint64_t pairs);
  void use_ids(std::uint64_t ids);

  struct Arrays {
    ReservedArray<AtomicSlot> pairs;
    ReservedArray<std::uint32_t> ids;
  };

  geometry::Aabb bounds_;
  const std::size_t references_;
  Capacity capacity_;
  AtomicSlot root_;
  std::atomic<FinishedSubtree*> top_{nullptr};
  std::atomic<Arrays*> arrays_{nullptr};
  // Copies of the arrays' addresses: one load less per step of a traversal.
  std::atomic<AtomicSlot*> pairs_{nullptr};
  std::atomic<std::uint32_t*> ids_{nullptr};
  // Written by every building thread: each on a cache line of its own, apart from what traversals
  // read.
  alignas(64) std::atomic<std::uint64_t> pairs_used_{0};
  alignas(64) std::atomic<std::uint64_t> ids_used_{0};
  std::atomic<int> makers_{0};          ///< NewNodes that live.
  std::atomic<std::uint64_t> turn_{0};  ///< Of the last NewNodes.
  std::shared_ptr<ListBytes> lists_ = std::make_shared<ListBytes>();
  std::atomic<std::uint64_t> peak_{0};
  /// Retired bytes from which on they are freed as soon as the thread leaves its pin.
  std::uint64_t free_soon_from_;
};

}  // namespace sightline::accel::kdtree
