// What the tasks of a build write: the cells of a plain kd-tree, within the room for them.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>

#include "accel/published/kd/plain_cells.h"

namespace sightline::accel::published::kd {

/// How many pairs and ids a tree may still get: some rules cut as long as the next cut pays,
/// whatever that takes. Threads: any.
class PlainCapacity {
 public:
  /// For a tree over that many references, whose leaves hold at most `budget` of them for each one
  /// (SplitSearch::budget); 0: as many as there is room for.
  PlainCapacity(double budget, std::size_t references);

  bool take_pair() { return take(pairs_, 1); }
  bool take_ids(std::size_t count) { return take(ids_, static_cast<std::int64_t>(count)); }

 private:
  static bool take(std::atomic<std::int64_t>& left, std::int64_t count) {
    if (left.fetch_sub(count, std::memory_order_relaxed) >= count) return true;
    left.fetch_add(count, std::memory_order_relaxed);
    return false;
  }

  std::atomic<std::int64_t> pairs_, ids_;
};

/// The cells that one task makes. Indices in its nodes are its own until append(). Threads: one.
class PlainWriter {
 public:
  explicit PlainWriter(PlainCapacity& capacity) : capacity_(capacity) {}

  PlainCapacity& capacity() const { return capacity_; }

  /// Whether there is room for the children of one more node, which is then taken.
  bool may_cut() { return capacity_.take_pair(); }
  /// The index of a new pair: a node comes before those below it.
  std::uint32_t begin_pair();
  void end_pair(std::uint32_t pair, PlainNode left, PlainNode right) {
    cells_.pairs[pair] = {left, right};
  }

  /// A leaf of these references; a failed one if there is no room for their ids.
  PlainNode leaf(std::span<const kdtree::Reference> refs);
  /// As above; failed() makes the failed one.
  template <class Failed>
  PlainNode leaf(std::span<const kdtree::Reference> refs, const Failed& failed) {
    if (refs.empty()) return {};
    if (refs.size() == 1) return PlainNode::leaf(1, refs[0].id);
    return capacity_.take_ids(refs.size()) ? long_leaf(refs) : failed();
  }
  /// Counted by TreeMetrics::failed_cells. Not empty.
  PlainNode failed_leaf(std::span<const kdtree::Reference> refs);

  /// Takes over the cells of another task, and returns its node as it is from now on.
  PlainNode append(const PlainWriter& other, PlainNode node);

  /// The whole tree. The writer is empty then.
  PlainCells finish(PlainNode root);

 private:
  PlainNode long_leaf(std::span<const kdtree::Reference> refs);

  PlainCapacity& capacity_;
  PlainCells cells_;
};

}  // namespace sightline::accel::published::kd
