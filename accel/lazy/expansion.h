// What one thread does with one cell that is not built, from the claim to what takes its place.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "accel/kdtree/kd_tree.h"
#include "accel/lazy/divide.h"
#include "accel/lazy/passes.h"
#include "accel/lazy/tree_context.h"

namespace sightline::accel::lazy {

/// What rays do at a cell that is not built.
enum class AtCell : std::uint8_t {
  kAdvance,  ///< The slot has changed: they read it again.
  kSearch,   ///< They search its list: another thread expands a small cell, or there is no room in
             ///< the memory of the trees.
  kSkip,     ///< They skip it. Only meet() returns this, for Growth::kBuiltOnly.
  kStop,     ///< They wait: other threads expand a large cell. They ask again when these have made
             ///< progress (LazyTree::progress), or wait elsewhere (CellQuery::awaited).
};

/// Most bytes of deferred cells and their lists for each reference of the root, in a tree with a
/// budget of references. A cell whose division exceeds it is not divided: its subtree is built at
/// once. The lists of a mesh whose triangles do not overlap take two thirds of it.
inline constexpr std::uint64_t kListBytes = 52;

/// Bytes of lists that matter in no mesh; small meshes divide their cells as others do.
inline constexpr std::uint64_t kSpareBytes = 4096;

inline std::uint64_t most_list_bytes(const TreeContext& context) {
  return kListBytes * context.size + kSpareBytes;
}

/// Passes over a large cell are shared by all threads that expand it. A small cell, and one whose
/// subtree is built at once, is claimed by one thread; if it throws, the cell is deferred again.
/// Threads: one, pinned to an epoch, but for build_claimed().
class Expansion {
 public:
  /// All of these outlive it. `cancelled`: see LazyTree::expand. Cells above the weight
  /// `fill_above` are wanted, so that a division cuts them again until a node is full.
  Expansion(TreeContext& context, kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
            const std::atomic<bool>* cancelled,
            std::uint64_t fill_above = std::numeric_limits<std::uint64_t>::max())
      : context_(context),
        slot_(slot),
        counters_(counters),
        cancelled_(cancelled),
        fill_above_(fill_above) {}
  ~Expansion() { release(); }
  Expansion(const Expansion&) = delete;
  Expansion& operator=(const Expansion&) = delete;

  /// Takes the cell a step on; `waits`: see LazyTree::expand. Throws std::bad_alloc.
  AtCell expand(bool waits);

  /// Claims a cell of the slot. False if it is claimed already, or replaced.
  bool claim(kdtree::DeferredCell& cell);
  /// Builds the subtree of the claimed cell; if cancelled, a part, whose cells wait with their
  /// lists, or nothing. No pin is needed, as no other thread retires a claimed cell. Returns
  /// whether a cell was claimed. Throws std::bad_alloc.
  bool build_claimed();
  /// Puts a cell in the place of `cell` that will be built at once, without what passes over the
  /// list of `cell` have made. A list of everything is made again: it takes as much memory as all
  /// else.
  void mark_whole(kdtree::DeferredCell& cell);

 private:
  kdtree::Slot slot_of(const kdtree::DeferredCell& cell) const;
  void release();
  void publish(kdtree::DeferredCell& cell, kdtree::Slot next);
  AtCell wait_for_owner(const kdtree::DeferredCell& cell, bool waits);
  AtCell expand_shared(kdtree::DeferredCell& cell, bool waits);
  void expand_claimed(kdtree::DeferredCell& cell, bool at_once);
  bool divide_cell(kdtree::DeferredCell& cell, const Passes& passes);
  bool may_wait(const Division& division, const kdtree::DeferredCell& cell) const;
  kdtree::Slot make_slot(Division division, const kdtree::DeferredCell& cell);
  std::uint64_t fill_above(const kdtree::DeferredCell& cell) const;
  kdtree::Slot make_node(Division division);
  grow::GrowContext grow_context() const;

  TreeContext& context_;
  kdtree::AtomicSlot& slot_;
  kdtree::BuildCounters& counters_;
  const std::atomic<bool>* cancelled_;
  const std::uint64_t fill_above_;
  kdtree::DeferredCell* claimed_ = nullptr;
  PassChain* passes_ = nullptr;  ///< Those of a large cell.
};

}  // namespace sightline::accel::lazy
