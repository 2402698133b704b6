// One pass over a long list, done in slices by any threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "accel/kdtree/reference_list.h"
#include "accel/lazy/partition.h"
#include "accel/lazy/shared_slices.h"
#include "accel/lazy/split_tree.h"
#include "accel/split/child_scan.h"
#include "accel/split/scan_pass.h"

namespace sightline::accel::lazy {

/// Thrown by a thread that leaves a pass because its query is cancelled.
struct Cancelled {};

/// Whether the query is cancelled. Null: it never is.
inline bool is_set(const std::atomic<bool>* cancelled) {
  return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
}

/// The result of one slice. Each kind of pass sets its members.
struct PassSlice {
  split::PassResult sums;  ///< Scanning.
  std::shared_ptr<const kdtree::ReferenceList> left,
      right;                                ///< Sifting; opening and listing set `left`.
  kdtree::ChildScan left_scan, right_scan;  ///< Counts over the children's lists.
  Straddling straddling;                    ///< Straddlers of the split.
  bool openable = false;                    ///< The lists may have openable references.
  std::optional<kdtree::Split> cut;       ///< Choosing, for rules that need the list in one piece.
  std::shared_ptr<const SplitTree> cuts;  ///< Choosing by a sample of the list.
  std::vector<std::shared_ptr<const kdtree::ReferenceList>>
      parts;  ///< Sifting by the splits of a SplitTree.
};

/// Slices are pure functions of the pass's input, so several threads may do the same slice: the
/// first result is kept. No thread waits for another in here, and a thread that is suspended does
/// not stop the others: see finish(). Threads: any.
class SharedPass {
 public:
  /// Does one slice. Owns all that it reads. Adds its work to the counters.
  using Work = std::function<std::unique_ptr<PassSlice>(std::size_t slice, kdtree::BuildCounters&)>;

  SharedPass(std::size_t slices, Work work) : work_(std::move(work)), results_(slices) {}

  /// Does slices that no thread has begun, until none is left. Returns their number. Throws
  /// std::bad_alloc; Cancelled before a slice if stop() is true.
  template <class Stop>
  std::size_t help(kdtree::BuildCounters& counters, const Stop& stop) {
    return results_.help([&](std::size_t slice) { return make(slice, counters, stop); });
  }

  /// Returns when all slices are done: by this thread, by others while it waits, or by this thread
  /// after all if those seem to be stopped. Throws as help().
  template <class Stop>
  void complete(kdtree::BuildCounters& counters, const Stop& stop) {
    constexpr int kStalls = 1;
    results_.complete(kStalls, [&](std::size_t slice) { return make(slice, counters, stop); });
  }

  std::size_t slices() const { return results_.size(); }
  /// A lower bound.
  std::size_t slices_done() const { return results_.size_done(); }

  /// Of a slice that is done.
  const PassSlice& operator[](std::size_t slice) const { return results_[slice]; }

  /// The next pass, or null.
  std::atomic<SharedPass*> next{nullptr};

 private:
  template <class Stop>
  std::unique_ptr<PassSlice> make(std::size_t slice, kdtree::BuildCounters& counters,
                                  const Stop& stop) {
    if (stop()) throw Cancelled();
    return work_(slice, counters);
  }

  Work work_;
  SharedSlices<PassSlice> results_;
};

}  // namespace sightline::accel::lazy
