// What the tasks of a build write: the cells of a plain kd-tree, within the room for them.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>

#include "accel/published/kd/plain_cells.h"

namespace sightline::accel::published::kd {

/// The number of pairs and ids that a tree may still get. It is limited, as some rules cut as long
/// as the next cut pays, whatever memory that takes. Threads: any.
class PlainCapacity {
 public:
  /// Makes the capacity for a tree over that many references, whose leaves hold at most `budget`
  /// ids for each of them (SplitSearch::budget); 0 stands for no budget.
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

  /// Takes capacity for the children of one more node; false if there is none.
  bool may_cut() { return capacity_.take_pair(); }
  /// Returns the index of a new pair. A node is begun before the nodes below it, and so comes
  /// first.
  std::uint32_t begin_pair();
  void end_pair(std::uint32_t pair, PlainNode left, PlainNode right) {
    cells_.pairs[pair] = {left, right};
  }

  /// Makes a leaf of these references, or a failed one if there is no room for their ids.
  PlainNode leaf(std::span<const kdtree::Reference> refs);
  /// Makes a leaf as the overload above does; failed() makes the failed one.
  template <class Failed>
  PlainNode leaf(std::span<const kdtree::Reference> refs, const Failed& failed) {
    if (refs.empty()) return {};
    if (refs.size() == 1) return PlainNode::leaf(1, refs[0].id);
    return capacity_.take_ids(refs.size()) ? long_leaf(refs) : failed();
  }
  /// Makes a failed leaf, which TreeMetrics::failed_cells counts. `refs` is not empty.
  PlainNode failed_leaf(std::span<const kdtree::Reference> refs);

  /// Takes over the cells of another task, and returns its node as it is from now on.
  PlainNode append(const PlainWriter& other, PlainNode node);

  /// Returns the whole tree, and leaves the writer empty.
  PlainCells finish(PlainNode root);

 private:
  PlainNode long_leaf(std::span<const kdtree::Reference> refs);

  PlainCapacity& capacity_;
  PlainCells cells_;
};

}  // namespace sightline::accel::published::kd
