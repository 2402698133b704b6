// A kd-tree that grows where rays look: what happens between a ray's first step into a cell that is
// not built and the moment the cell is built.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/lazy/demand.h"
#include "accel/lazy/eviction.h"
#include "accel/lazy/expansion.h"
#include "accel/lazy/tree_context.h"

namespace sightline::accel::lazy {

/// Threads: every member may be called from any thread at any time; expand() and progress() pinned
/// to an epoch (EpochPin).
/// A thread that is stopped inside a member, at any point, does not stop any other.
class LazyTree {
 public:
  /// `bounds` contains every reference; `primitive_count` is an upper bound on their number when
  /// all are opened. `mesh`: the mesh whose faces they are, for rules that clip; null for other
  /// references. It must outlive the tree. `memory`: what its bytes count in, and asks before it
  /// grows; null: it may always grow.
  LazyTree(const geometry::Aabb& bounds, std::size_t primitive_count, split::SplitRule rule,
           ReferenceSource source, const geometry::MeshView* mesh = nullptr,
           std::shared_ptr<kdtree::TreeMemory> memory = nullptr)
      : context_(bounds, primitive_count, std::move(rule), std::move(source), mesh,
                 std::move(memory)),
        complete_(context_.is_list) {}

  const kdtree::KdTree& tree() const { return context_.tree; }
  kdtree::AtomicSlot& root() { return context_.tree.root(); }

  /// Called by a ray that meets a deferred slot.
  ///
  /// First touch: one cell is divided (Division), and the new cells are deferred. The subtree of a
  /// small cell (TreeContext::is_eager) is built at once, and that of a cell whose lists would
  /// exceed kListBytes. Throws std::bad_alloc; a later call may succeed.
  ///
  /// Once `cancelled` is true, a thread leaves a large cell after a slice of it, with
  /// AtCell::kSearch, and a subtree that is built at once soon. What is done remains for the next
  /// ray.
  ///
  /// Where other threads expand a large cell, and no work is left to help with, a thread that does
  /// not wait returns AtCell::kStop. One that waits sleeps until they have made progress, and does
  /// their work if they seem to be stopped.
  AtCell expand(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                const std::atomic<bool>* cancelled = nullptr, bool waits = true);

  /// Whether its references are faces. Cells of other trees are always worth expanding: searching
  /// them would enter all that a ray meets, in any order.
  bool is_over_faces() const { return context_.mesh != nullptr; }

  /// Called for rays that meet a cell. Returns whether they search its list, and then counts what
  /// that costs as spent: because memory is short, or because all that was spent there is still
  /// less than the cost of expanding it. Costs are compared `by_demand` in trees over faces, and
  /// always where the cell was evicted.
  bool searches(const kdtree::DeferredCell& cell, std::uint64_t rays, bool by_demand,
                kdtree::BuildCounters& counters);

  /// Whether a cell is the root over a hierarchy (ReferenceSource::known). A search of it leaves
  /// nothing out and builds nothing; what it costs is counted as spent by the one who searches.
  bool is_hierarchy(const kdtree::DeferredCell& cell) const {
    return context_.source->known != nullptr && !cell.has_list;
  }
  /// Whether rays search it, as that has cost less than growing the tree.
  bool searches_hierarchy(const kdtree::DeferredCell& cell) const;

  /// Whether this number of rays of a batch pays for expanding the cell. Spends nothing.
  bool pays(const kdtree::DeferredCell& cell, double rays, kdtree::BuildCounters& counters) const;
  /// Whether rays that pay for a cell, and each of which stands for several, reach so much of it
  /// that its whole subtree is built (finish).
  bool pays_for_all(const kdtree::DeferredCell& cell, std::span<const geometry::LocalRay> waiting,
                    double rays_each, kdtree::BuildCounters& counters) const;

  /// Counts rays that walk the tree, while it is not complete.
  void count_rays(std::uint64_t rays);
  /// Whether they have spent as much on that as building all of the tree costs: what is in one
  /// piece is walked faster.
  bool has_paid_for_all() const;

  /// Expands all cells below a slot. As expand_all() otherwise.
  void finish(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
              const std::atomic<bool>* cancelled = nullptr);

  /// Measures the progress of a busy slot's expansion: grows while threads work on it.
  static std::uint64_t progress(const kdtree::AtomicSlot& slot);

  /// Expands all cells, or until `cancelled` is set. Not
  /// beyond TreeMemory::low_water(), and no evicted cells unless all of them fit below it.
  /// Parallel in the caller's arena. The caller is not pinned: a pin would keep the lists of all
  /// cells alive. Throws std::bad_alloc; a later call may succeed.
  void expand_all(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled = nullptr);

  /// Whether expand_all() has found nothing left to expand. Then it returns at once.
  bool is_complete() const { return complete_.load(std::memory_order_acquire); }

  /// Appends what can be evicted: finished subtrees, and lists that can be made again. Pinned.
  void list_evictable(std::vector<Evictable>& found);
  /// Evicts it, unless it has changed since it was listed. Returns the bytes that are freed once no
  /// walk reads them. Pinned. Throws std::bad_alloc, and then nothing has changed.
  std::uint64_t evict(const Evictable& piece);

  /// Whether finished cells become leaf blocks: it is over faces, and floats can test them in the
  /// tree's sizes (wide::kLeastSize). Where they cannot, the tree stays the list that it begins as.
  bool makes_blocks() const { return context_.makes_blocks; }
  /// What its wide trees are relative to. Not for empty bounds.
  const wide::Frame& frame() const { return context_.frame; }

  /// The reference of a tree that is one list of one; nothing for other trees. Pinned.
  std::optional<std::uint32_t> only() const;

 private:
  bool pays_for(const kdtree::DeferredCell& cell, std::uint64_t spent,
                kdtree::BuildCounters& counters) const;
  /// Whether planes cut too many of the references for a division to make lists much shorter.
  bool is_overlapping(const kdtree::DeferredCell& root, kdtree::BuildCounters& counters) const;
  std::uint64_t cost_of_expanding(const kdtree::DeferredCell& cell) const;

  TreeContext context_;
  std::atomic<std::uint64_t> rays_{0};  ///< See count_rays().
  enum class Known : std::uint8_t { kNot, kNo, kYes };
  mutable std::atomic<Known> overlapping_{Known::kNot};  ///< See is_overlapping().
  std::atomic<bool> complete_;
  std::atomic<std::uint64_t> evicted_{0};  ///< Pieces, so far.
};

}  // namespace sightline::accel::lazy
