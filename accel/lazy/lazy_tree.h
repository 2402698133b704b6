// A kd-tree that grows where rays look: what happens between a ray's first step into a cell that is
// not built and the moment the cell is built.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/grow/grow.h"
#include "accel/kdtree/kd_tree.h"
#include "accel/lazy/demand.h"
#include "accel/lazy/divide.h"
#include "accel/lazy/eviction.h"
#include "accel/wide/frame.h"

namespace sightline::accel::lazy {

/// The answer to a ray that asks for a cell.
enum class ExpandResult : std::uint8_t {
  kRetry,     ///< The slot has changed: read it again.
  kPending,   ///< Other threads expand a large cell: ask again when they have made progress.
  kScanList,  ///< Search the cell's list: another thread expands a small cell, or there is no room
              ///< in the memory of the trees.
};

/// What to do when other threads expand a large cell and no work is left to help with.
enum class WhenPending : std::uint8_t {
  kReturn,  ///< Return kPending.
  kWait,    ///< Sleep until they have made progress; if they seem to be stopped, do their work.
};

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
           std::shared_ptr<kdtree::TreeMemory> memory = nullptr);

  const kdtree::KdTree& tree() const { return tree_; }
  kdtree::AtomicSlot& root() { return tree_.root(); }

  /// Called by a ray that meets a deferred slot.
  ///
  /// First touch: one cell is divided (Division), and the new cells are deferred. The subtree of a
  /// small cell (is_eager()) is built at once, and that of a cell whose lists would exceed
  /// kListBytes. Throws std::bad_alloc; a later call may succeed.
  ///
  /// Once `cancelled` is true, a thread leaves a large cell after a slice of it, with kScanList,
  /// and a subtree that is built at once soon. What is done remains for the next ray.
  ExpandResult expand(kdtree::AtomicSlot& slot, WhenPending when_pending,
                      kdtree::BuildCounters& counters,
                      const std::atomic<bool>* cancelled = nullptr);

  /// Whether its references are faces. Cells of other trees are always worth expanding: searching
  /// them would enter all that a ray meets, in any order.
  bool is_over_faces() const { return context_.mesh != nullptr; }

  /// Called for rays that meet a cell. True: they search its list, which counts as spent, because
  /// there is no room for more; or because that, with what was spent there before, costs less than
  /// expanding it. The costs count `by_demand` in trees over faces, and always where the cell was
  /// evicted.
  bool searches(const kdtree::DeferredCell& cell, std::uint64_t rays, bool by_demand,
                kdtree::BuildCounters& counters);

  /// Whether a cell is the root over a hierarchy (ReferenceSource::known). A search of it leaves
  /// nothing out and builds nothing; what it costs is counted as spent by the one who searches.
  bool is_hierarchy(const kdtree::DeferredCell& cell) const {
    return source_.known != nullptr && !cell.has_list;
  }
  /// Whether rays search it, as that has cost less than growing the tree.
  bool searches_hierarchy(const kdtree::DeferredCell& cell) const;

  /// As above, for rays of a batch that wait at the cell, each of which stands for several. Spends
  /// nothing.
  CellDecision decide(const kdtree::DeferredCell& cell, std::span<const geometry::LocalRay> waiting,
                      double rays_each, kdtree::BuildCounters& counters) const;
  /// Whether that is another than to search, for this number of rays.
  bool pays(const kdtree::DeferredCell& cell, double rays, kdtree::BuildCounters& counters) const;

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
  bool makes_blocks() const { return makes_blocks_; }
  /// What its wide trees are relative to. Not for empty bounds.
  const wide::Frame& frame() const { return frame_; }

  /// The reference of a tree that is one list of one; nothing for other trees. Pinned.
  std::optional<std::uint32_t> only() const;

 private:
  bool is_evictable() const;
  bool may_grow(const kdtree::DeferredCell& cell) const;
  bool may_build_ahead() const;
  void list_evictable(kdtree::AtomicSlot& slot, const geometry::Aabb& cell, int depth,
                      std::vector<Evictable>& found);
  std::unique_ptr<kdtree::DeferredCell> evicted_subtree(const Evictable& piece,
                                                        const kdtree::FinishedSubtree& subtree);
  std::unique_ptr<kdtree::DeferredCell> with_compact_list(const kdtree::DeferredCell& cell) const;
  kdtree::ReferenceList list_again(const kdtree::DeferredCell& cell,
                                   kdtree::BuildCounters& counters) const;
  std::unique_ptr<kdtree::DeferredCell> with_list_again(const kdtree::DeferredCell& cell,
                                                        kdtree::BuildCounters& counters) const;
  bool has_capacity_for(std::uint64_t bytes) const;
  void heed_capacity(Division& division) const;
  void divide_compact(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                      kdtree::BuildCounters& counters);
  bool evicted_must_wait(std::uint64_t references) const;
  bool pays_for(const kdtree::DeferredCell& cell, std::uint64_t spent,
                kdtree::BuildCounters& counters) const;
  /// Whether planes cut too many of the references for a division to make lists much shorter.
  bool is_overlapping(const kdtree::DeferredCell& root, kdtree::BuildCounters& counters) const;
  kdtree::ReferenceList whole_list(const kdtree::DeferredCell& cell, bool& openable,
                                   kdtree::BuildCounters& counters,
                                   const std::atomic<bool>* cancelled) const;
  bool is_eager(const kdtree::DeferredCell& cell) const;
  std::uint64_t cost_of_expanding(const kdtree::DeferredCell& cell) const;
  grow::GrowContext grow_context(const std::atomic<bool>* cancelled);
  double budget() const;
  ExpandResult expand_now(kdtree::AtomicSlot& slot, WhenPending when_pending,
                          kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);
  ExpandResult wait_for_owner(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell,
                              WhenPending when_pending, const std::atomic<bool>* cancelled);
  ExpandResult expand_claimed(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                              kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);
  ExpandResult expand_large(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                            WhenPending when_pending, kdtree::BuildCounters& counters,
                            const std::atomic<bool>* cancelled);
  ExpandResult run_all_passes(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, CellTask& task,
                              kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);
  kdtree::Slot make_slot(Division division, const kdtree::DeferredCell& cell);
  kdtree::Slot make_node(Division& division);
  kdtree::Slot defer(NewCell now, bool compact = false);
  void complete(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                const std::atomic<bool>* cancelled);
  enum class Step : std::uint8_t { kBuilt, kAgain, kWait, kClaimed };
  Step step(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
            const std::atomic<bool>* cancelled, kdtree::DeferredCell*& claimed);
  bool lists_are_left_over() const;
  bool build_left_over(const kdtree::AtomicSlot* before, kdtree::BuildCounters& counters,
                       const std::atomic<bool>* cancelled);
  std::uint64_t most_list_bytes() const;
  bool may_list_root(kdtree::BuildCounters& counters) const;
  void complete_claimed(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell,
                        kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled);
  bool may_wait(const Division& division, const kdtree::DeferredCell& cell) const;
  bool holds_all(const kdtree::DeferredCell& cell) const;
  void mark_whole(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell);
  static bool claim(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell);
  void release_claim(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell);
  void publish(kdtree::AtomicSlot& slot, kdtree::DeferredCell& cell, kdtree::Slot built,
               kdtree::BuildCounters& counters);
  void count(const kdtree::AtomicSlot& slot, kdtree::Slot built, kdtree::BuildCounters& counters);

  kdtree::KdTree tree_;
  split::SplitRule rule_;
  ReferenceSource source_;
  std::size_t primitive_count_;
  DivideContext context_;
  const wide::Frame frame_;
  const bool makes_blocks_, is_list_;
  std::atomic<std::uint64_t> rays_{0};  ///< See count_rays().
  enum class Known : std::uint8_t { kNot, kNo, kYes };
  mutable std::atomic<Known> overlapping_{Known::kNot};  ///< See is_overlapping().
  std::atomic<bool> complete_;
  std::atomic<std::uint64_t> evicted_{0};  ///< Pieces, so far.
};

/// A mesh of at most this number of triangles becomes leaf blocks at once.
inline constexpr std::size_t kWholeMesh = 1000;

/// Most bytes of deferred cells and their lists for each reference of the root, in a tree with a
/// budget of references. A cell whose division exceeds it is not divided: its subtree is built at
/// once. The lists of a mesh whose triangles do not overlap take two thirds of it.
inline constexpr std::uint64_t kListBytes = 52;

}  // namespace sightline::accel::lazy
