// The interface between split rules and the code that grows trees.
#pragma once

#include <cstddef>
#include <optional>

#include "accel/kdtree/reference.h"
#include "accel/split/child_scan.h"
#include "accel/split/split_rule.h"

namespace sightline::accel::split {

/// A rule that decides where cells are split. It is called once per cell, not by traversals.
/// Immutable. Threads: any, for all members.
class SplitSearch {
 public:
  SplitSearch() = default;
  virtual ~SplitSearch() = default;
  SplitSearch(const SplitSearch&) = delete;
  SplitSearch& operator=(const SplitSearch&) = delete;

  /// Returns the split, or nothing for a leaf.
  virtual std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                              kdtree::BuildCounters& counters) const = 0;

  /// Whether straddlers are clipped after a split of a cell's list, or of a slice of it, that
  /// leaves `straddlers` of `references` on both sides.
  virtual bool clips(std::size_t /*straddlers*/, std::size_t /*references*/) const { return false; }

  /// Whether `choose` works through passes alone (CellRefs::run). Otherwise it needs the list in
  /// one piece.
  virtual bool runs_passes() const { return false; }

  /// Whether a long list may be split by a sample of it.
  virtual bool takes_samples() const { return false; }

  /// Whether sifting a list of `references` also counts the first passes over the resulting lists
  /// (sift_and_count). `choose` then gets the counts as CellRefs::first.
  virtual bool scans_children(std::size_t /*references*/) const { return false; }

  /// The planes of the first pass over a child's list, for rules that scan children.
  virtual ChildPlanes child_planes(const geometry::Aabb& /*child*/) const { return {}; }

  /// Limit on references per triangle in a tree (reference_budget.h), or above its leaf blocks,
  /// where a tree ends `in_blocks`; 0: no limit.
  virtual double budget([[maybe_unused]] bool in_blocks) const { return 0; }
};

}  // namespace sightline::accel::split
