// Walking a ray through a tree that grows: what happens at cells that are not built.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "accel/kdtree/walk.h"
#include "accel/lazy/lazy_tree.h"

namespace sightline::accel::lazy {

/// What a walk does at a cell that is not built.
enum class AtUnbuilt : std::uint8_t {
  kExpand,  ///< Build it, or help to; search its list while other threads build a small one.
  kSearch,  ///< Search its list: test the references whose boxes the ray meets.
  kSkip,    ///< Skip it.
};

/// The part of a query that concerns cells that are not built.
struct LazyQuery {
  AtUnbuilt at_unbuilt = AtUnbuilt::kExpand;
  AtBusy at_busy = AtBusy::kWait;
  bool met_unbuilt = false;  ///< A cell was skipped, or its list was searched.
  /// With AtBusy::kLeave: the walk met a large cell that other threads build, and stopped. Ask
  /// again, with a fresh query, when `progress` has increased.
  bool put_aside = false;
  std::uint64_t progress = 0;  ///< Of that cell.
};

/// The visitor of kdtree::walk for a tree that grows.
template <class Test>
struct LazyVisit {
  LazyTree& tree;
  LazyQuery& query;
  kdtree::BuildCounters& built;
  Test& test;

  bool leaf(std::span<const std::uint32_t> references) { return test.leaf(references); }
  double limit() { return test.limit(); }

  kdtree::Unbuilt unbuilt(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell) {
    if (query.at_unbuilt == AtUnbuilt::kExpand) {
      const Expanded expanded = tree.expand(slot, query.at_busy, built);
      if (expanded == Expanded::kAgain) return kdtree::Unbuilt::kAgain;
      if (expanded == Expanded::kBusy) {
        query.put_aside = true;
        query.progress = LazyTree::progress(slot);
        return kdtree::Unbuilt::kStop;
      }
    }
    query.met_unbuilt = true;
    if (query.at_unbuilt == AtUnbuilt::kSkip) return kdtree::Unbuilt::kDone;
    return search(cell) ? kdtree::Unbuilt::kStop : kdtree::Unbuilt::kDone;
  }

  bool search(const kdtree::DeferredCell& cell) {
    if (!cell.listed) return test.everything();
    return cell.list.any_part([&](std::span<const kdtree::BoxRef> refs) {
      return std::any_of(refs.begin(), refs.end(),
                         [&](const kdtree::BoxRef& ref) { return test.reference(ref); });
    });
  }
};

/// Visits the leaves that the ray enters, near to far, and deals with the cells on its way that are
/// not built. Meshes' trees and the scene's are walked by this.
///
/// `test` supplies, each returning true to stop the walk:
///   bool leaf(span<const uint32_t> references)  a leaf that is not empty
///   bool reference(const BoxRef&)               one reference of a searched list
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
