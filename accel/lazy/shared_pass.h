// One pass over a long list, made in slices by all threads that expand the cell.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "accel/kdtree/reference_list.h"
#include "accel/lazy/shared_slices.h"
#include "accel/lazy/sieve.h"
#include "accel/lazy/split_tree.h"
#include "accel/split/child_scan.h"
#include "accel/split/scan_pass.h"

namespace sightline::accel::lazy {

/// The result of one slice. Each kind of pass fills its part.
struct SliceResult {
  split::PassResult sums;  ///< Scanning.
  std::shared_ptr<const kdtree::BoxList> left,
      right;                                ///< Sifting; opening and listing fill `left`.
  kdtree::FirstScan left_scan, right_scan;  ///< Of the children's lists.
  Straddling straddling;                    ///< Of the division.
  bool openable = false;                    ///< There may be openable ones in the lists.
  std::optional<kdtree::Cut> cut;           ///< Choosing, where a builder takes no slices.
  std::shared_ptr<const CutTree> cuts;      ///< Choosing by a sample.
  std::vector<std::shared_ptr<const kdtree::BoxList>> parts;  ///< Sifting by these cuts.
};

/// A pass over one list. Its slices are pure functions of what the stage was made with, so it does
/// not matter how often one is made, or by which thread. Threads: all members, any.
class Stage {
 public:
  /// Owns all that it reads. Adds what it did to the counters.
  using Work =
      std::function<std::unique_ptr<SliceResult>(std::size_t slice, kdtree::BuildCounters&)>;

  Stage(std::size_t slices, Work work) : work_(std::move(work)), results_(slices) {}

  /// Makes slices that no thread has begun until none is left. Returns how many. Throws
  /// std::bad_alloc.
  std::size_t help(kdtree::BuildCounters& counters) {
    return results_.help([&](std::size_t slice) { return work_(slice, counters); });
  }

  /// Returns when all slices are done: by this thread, by others while it waits, or by this thread
  /// after all if those seem to be stopped. Throws std::bad_alloc.
  void complete(kdtree::BuildCounters& counters) {
    constexpr int kStalls = 1;
    results_.complete(kStalls, [&](std::size_t slice) { return work_(slice, counters); });
  }

  std::size_t slices() const { return results_.size(); }
  /// A lower bound.
  std::size_t slices_done() const { return results_.size_done(); }

  /// Of a slice that is done.
  const SliceResult& operator[](std::size_t slice) const { return results_[slice]; }

  /// The stage behind this one, or null.
  std::atomic<Stage*> next{nullptr};

 private:
  Work work_;
  SharedSlices<SliceResult> results_;
};

}  // namespace sightline::accel::lazy
