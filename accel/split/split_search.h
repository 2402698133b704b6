// The one interface between a rule that says where to cut cells and what grows a tree by it.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "accel/kdtree/reference.h"
#include "accel/kdtree/slot.h"
#include "accel/split/child_scan.h"
#include "accel/split/exhaustive_split.h"

namespace sightline::accel::grow {
struct GrowContext;
}

namespace sightline::accel::split {

/// Where to cut a cell. Asked once a cell, never by a ray. Immutable.
/// Threads: all members, from any.
class SplitSearch {
 public:
  SplitSearch() = default;
  virtual ~SplitSearch() = default;
  SplitSearch(const SplitSearch&) = delete;
  SplitSearch& operator=(const SplitSearch&) = delete;

  /// The cut, or nothing for a leaf.
  virtual std::optional<kdtree::Cut> choose(const kdtree::CellRefs& cell,
                                            kdtree::BuildCounters& counters) const = 0;

  /// Whether the straddlers of a cut are clipped that leaves `straddlers` of a cell's `references`
  /// on both sides. `references` is 0 where only a slice of the list is known.
  virtual bool clips(std::size_t /*straddlers*/, std::size_t /*references*/) const { return false; }

  /// Whether `choose` can work through passes alone (CellRefs::run). Otherwise it needs the whole
  /// list.
  virtual bool runs_passes() const { return false; }

  /// Whether a long list may be cut where a sample of it would be.
  virtual bool takes_samples() const { return false; }

  /// Whether trees may begin with runs of triangles. Runs are opened by the rule of membership, so
  /// a rule that chooses the side of flat boxes must refuse them.
  virtual bool takes_runs() const { return true; }

  /// Whether the lists that result from sifting a list of `references` are counted meanwhile
  /// (sift_and_scan), and passed to `choose` as CellRefs::first.
  virtual bool scans_children(std::size_t /*references*/) const { return false; }

  /// For rules that scan children: where the first pass over that child's list counts.
  virtual FirstPlanes first_planes(const geometry::Aabb& /*child*/) const { return {}; }

  /// How every list of at most kSmallList references is cut, if `choose` always does so by its
  /// bounds and never clips: such subtrees are grown in registers (grow/small_subtree.h).
  virtual std::optional<BoundRule> small_rule() const { return std::nullopt; }

  /// References a triangle that the cuts of a tree may reach (reference_budget.h); 0: no limit.
  virtual double budget() const { return 0; }

  /// Depth at which cells of a tree over that many references become leaves.
  virtual int depth_bound(std::size_t /*references*/) const {
    return std::numeric_limits<int>::max();
  }

  /// The subtree under a cell, for rules that have a faster way than cell by cell. It must equal
  /// what `choose` leads to. Nothing: grow cell by cell.
  virtual std::optional<kdtree::Slot> grow_subtree(const grow::GrowContext& /*context*/,
                                                   std::span<const kdtree::BoxRef> /*refs*/,
                                                   const geometry::Aabb& /*cell*/,
                                                   const kdtree::CellPath& /*path*/,
                                                   kdtree::BuildCounters& /*counters*/) const {
    return std::nullopt;
  }
};

/// Shared by the trees and by work that may outlive them. Never null.
using SplitRule = std::shared_ptr<const SplitSearch>;

}  // namespace sightline::accel::split
