// Walking a ray through a tree that grows: what happens at cells that are not built.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/ref_counted.h"
#include "accel/kdtree/traverse.h"
#include "accel/lazy/lazy_tree.h"

namespace sightline::accel::lazy {

/// What a walk does at a cell that is not built.
enum class OnDeferred : std::uint8_t {
  kExpand,  ///< Build it, or help to; search its list while other threads build a small one.
  kDemand,  ///< As kExpand where that pays (LazyTree::searches), else as kScan.
  kWait,    ///< In trees over faces, wait there (LazyQuery::awaited); in others as kExpand.
  kScan,    ///< Do not expand; test the references whose boxes the ray meets.
  kSkip,    ///< Skip it.
};

/// Where a ray waits (OnDeferred::kWait).
struct Awaited {
  LazyTree* tree = nullptr;            ///< Null: it does not wait.
  kdtree::AtomicSlot* slot = nullptr;  ///< Null: it waits for all of a tree that rays have paid for
                                       ///< (LazyTree::has_paid_for_all).
};

/// The part of a query that concerns cells that are not built.
struct LazyQuery {
  OnDeferred on_deferred = OnDeferred::kExpand;
  WhenPending when_pending = WhenPending::kWait;
  bool saw_deferred = false;  ///< A cell was skipped, or its list was searched.
  /// With WhenPending::kReturn: the walk met a large cell that other threads build, and stopped.
  /// Ask again, with a fresh query, when `progress` has increased. With OnDeferred::kWait: the
  /// walk stopped at `awaited`.
  bool suspended = false;
  Awaited awaited;
  std::uint64_t progress = 0;  ///< Of that cell.
  /// The walking thread's pin; renewed after cells were built, so that their old lists are freed.
  /// Null: it is not renewed.
  kdtree::EpochPin* pin = nullptr;
  kdtree::RefCounted* owner = nullptr;  ///< See OwnedTree.
  bool joined = false;                  ///< The owner, before the pin was renewed.
  bool searches_list = false;  ///< The walk, or one around it, reads the list of a deferred cell.
  /// Once true, the walk stops soon, also inside a long list or an expansion, and what it has found
  /// means nothing. Null: never.
  const std::atomic<bool>* cancelled = nullptr;

  bool is_cancelled() const { return is_set(cancelled); }

  void wait_at(LazyTree& tree, kdtree::AtomicSlot* slot) {
    awaited = {&tree, slot};
    suspended = true;
  }

  void renew_pin() {
    if (pin == nullptr || searches_list) return;
    if (owner != nullptr && !joined) {
      owner->join();
      joined = true;
    }
    pin->renew_for_cells();
  }
};

/// While it lives, the tree that the query walks belongs to `owner`, which the thread's pin keeps
/// alive until it is renewed.
class OwnedTree {
 public:
  OwnedTree(LazyQuery& query, kdtree::RefCounted& owner) : query_(query) { query_.owner = &owner; }
  ~OwnedTree() {
    if (std::exchange(query_.joined, false)) query_.owner->leave();
    query_.owner = nullptr;
  }
  OwnedTree(const OwnedTree&) = delete;
  OwnedTree& operator=(const OwnedTree&) = delete;

 private:
  LazyQuery& query_;
};

/// References or triangles of a list that are searched between two looks at LazyQuery::cancelled.
inline constexpr std::size_t kSearchStep = 1024;

/// The visitor of kdtree::walk for a tree that grows.
template <class Test>
struct LazyVisit {
  LazyTree& tree;
  LazyQuery& query;
  kdtree::BuildCounters& built;
  Test& test;

  bool leaf(std::span<const std::uint32_t> references) { return test.leaf(references); }
  bool finished(const kdtree::FinishedSubtree& subtree) {
    subtree.last_use.use();
    return test.finished(subtree);
  }
  double limit() { return test.limit(); }

  /// Whether one ray expands the cell.
  bool expands(const kdtree::DeferredCell& cell) {
    if (query.on_deferred == OnDeferred::kScan || query.on_deferred == OnDeferred::kSkip)
      return false;
    return !tree.searches(cell, 1, query.on_deferred == OnDeferred::kDemand, built);
  }

  kdtree::DeferredAction deferred(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell) {
    if (query.on_deferred == OnDeferred::kWait && tree.is_over_faces()) {
      query.wait_at(tree, &slot);
      return kdtree::DeferredAction::kStop;
    }
    if (expands(cell)) {
      const ExpandResult expanded = tree.expand(slot, query.when_pending, built, query.cancelled);
      if (expanded == ExpandResult::kRetry) {
        query.renew_pin();
        return kdtree::DeferredAction::kRetry;
      }
      if (expanded == ExpandResult::kPending) {
        query.suspended = true;
        query.progress = LazyTree::progress(slot);
        return kdtree::DeferredAction::kStop;
      }
    }
    query.saw_deferred = true;
    if (query.on_deferred == OnDeferred::kSkip) return kdtree::DeferredAction::kDone;
    const bool searched_before = std::exchange(query.searches_list, true);
    const bool stop = search(cell);
    query.searches_list = searched_before;
    return stop ? kdtree::DeferredAction::kStop : kdtree::DeferredAction::kDone;
  }

  bool search(const kdtree::DeferredCell& cell) {
    cell.last_use.use();
    if (!cell.has_list) return test.everything();
    if (cell.list.is_compact()) return search(cell.list.ids());
    return cell.list.any_part([&](std::span<const kdtree::Reference> refs) {
      while (!refs.empty()) {
        if (query.is_cancelled()) return true;
        const auto part = refs.first(std::min(refs.size(), kSearchStep));
        refs = refs.subspan(part.size());
        if (test.references(part)) return true;
      }
      return false;
    });
  }

  bool search(std::span<const std::uint32_t> ids) {
    while (!ids.empty()) {
      if (query.is_cancelled()) return true;
      const auto part = ids.first(std::min(ids.size(), kSearchStep));
      ids = ids.subspan(part.size());
      if (test.leaf(part)) return true;
    }
    return false;
  }
};

/// Visits the leaves that the ray enters, near to far, and deals with the cells on its way that are
/// not built. Meshes' trees and the scene's are walked by this.
///
/// `test` supplies, each returning true to stop the walk:
///   bool leaf(span<const uint32_t> references)  a leaf that is not empty
///   bool finished(const FinishedSubtree&)       a finished subtree
///   bool references(span<const Reference>)      a part of a searched list
///   bool everything()                           the whole tree, before its root has a list
/// and
///   double limit()                              as for kdtree::walk
template <class Test>
void walk_lazily(LazyTree& tree, const kdtree::TreeRay& ray, LazyQuery& query,
                 kdtree::WalkCounters& walked, kdtree::BuildCounters& built, Test& test) {
  LazyVisit<Test> visit{tree, query, built, test};
  kdtree::walk(tree.tree(), ray, tree.root(), walked, visit);
}

}  // namespace sightline::accel::lazy
