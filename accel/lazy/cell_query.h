// What rays do at cells that are not built: a query says what it wants there, and the tree whether
// that pays.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/ref_counted.h"
#include "accel/lazy/growth.h"
#include "accel/lazy/lazy_tree.h"

namespace sightline::accel::lazy {

/// Where a sample ray waits.
struct Awaited {
  LazyTree* tree = nullptr;            ///< Null: it does not wait.
  kdtree::AtomicSlot* slot = nullptr;  ///< Null: it waits for all of a tree that rays have paid for
                                       ///< (LazyTree::has_paid_for_all).
};

/// The part of a query that concerns cells that are not built.
struct CellQuery {
  Growth growth = Growth::kFirstTouch;
  bool waits = true;  ///< See LazyTree::expand.
  /// Whether the rays are samples, which stop at cells over faces.
  bool samples = false;
  Awaited awaited;  ///< Where samples have stopped.
  /// Set where rays have stopped because the thread does not wait: the progress of the large cell
  /// that other threads build. Ask again when it has increased.
  std::uint64_t progress = 0;
  /// The walking thread's pin; renewed after cells were built, so that their old lists are freed.
  /// Null: it is not renewed.
  kdtree::EpochPin* pin = nullptr;
  kdtree::RefCounted* owner = nullptr;  ///< See OwnedTree.
  bool joined = false;                  ///< The owner, before the pin was renewed.
  bool renewed = false;                 ///< The pin.
  bool searches_list = false;  ///< The walk, or one around it, reads the list of a deferred cell.
  /// Once true, the walk stops soon, also inside a long list or an expansion, and what it has found
  /// means nothing. Null: never.
  const std::atomic<bool>* cancelled = nullptr;

  bool is_cancelled() const { return is_set(cancelled); }

  void renew_pin() {
    if (pin == nullptr || searches_list) return;
    if (owner != nullptr && !joined) {
      owner->join();
      joined = true;
    }
    renewed = true;
    pin->renew_for_cells();
  }
};

/// While it lives, the tree that the query walks belongs to `owner`. The thread's pin keeps the
/// owner alive; before the pin is renewed, the query joins the owner.
class OwnedTree {
 public:
  OwnedTree(CellQuery& query, kdtree::RefCounted& owner) : query_(query) { query_.owner = &owner; }
  ~OwnedTree() {
    if (std::exchange(query_.joined, false)) query_.owner->leave();
    query_.owner = nullptr;
  }
  OwnedTree(const OwnedTree&) = delete;
  OwnedTree& operator=(const OwnedTree&) = delete;

 private:
  CellQuery& query_;
};

/// Called once for the rays of a packet that meet a cell together: expands it, or helps to, where
/// the query wants that and the tree finds that it pays. Renews the query's pin after that. Throws
/// std::bad_alloc. Threads: any, pinned.
AtCell meet(LazyTree& tree, kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell,
            std::uint64_t rays, CellQuery& query, kdtree::BuildCounters& built);

}  // namespace sightline::accel::lazy
