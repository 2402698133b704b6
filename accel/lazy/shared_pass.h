// One pass over a long list, done in slices by whichever threads are there.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "accel/kdtree/reference_list.h"
#include "accel/lazy/partition.h"
#include "accel/lazy/split_tree.h"
#include "accel/split/child_scan.h"
#include "accel/split/scan_pass.h"

namespace sightline::accel::lazy {

/// What comes of one slice. Each kind of pass fills its part.
struct PassSlice {
  split::PassResult sums;  ///< Scanning.
  std::shared_ptr<const kdtree::ReferenceList> left,
      right;                                ///< Sifting; opening and listing fill `left`.
  kdtree::ChildScan left_scan, right_scan;  ///< Of the children's lists.
  Straddling straddling;                    ///< Of the division.
  bool openable = false;                    ///< There may be openable ones in the lists.
  std::optional<kdtree::Split> cut;         ///< Choosing, where a builder takes no slices.
  std::shared_ptr<const SplitTree> cuts;    ///< Choosing by a sample.
  std::vector<std::shared_ptr<const kdtree::ReferenceList>> parts;  ///< Sifting by these cuts.
};

/// Slices are pure functions of what the pass was made with, so it does not matter how often one
/// is done, nor by whom: the first result is kept. No thread ever waits for another in here, and
/// none that is stopped keeps the others from going on: see finish(). Threads: any.
class SharedPass {
 public:
  /// Owns all that it reads. Adds what it did to the counters.
  using Work = std::function<std::unique_ptr<PassSlice>(std::size_t slice, kdtree::BuildCounters&)>;

  SharedPass(std::size_t slices, Work work);
  ~SharedPass();
  SharedPass(const SharedPass&) = delete;
  SharedPass& operator=(const SharedPass&) = delete;

  /// Does slices that nobody has begun until there is none left. Returns how many. Throws
  /// std::bad_alloc.
  std::size_t help(kdtree::BuildCounters& counters);

  /// Does the slices, too, that others have begun: for when those seem to be stopped. Every slice
  /// is done then, even if done() does not say so yet.
  void finish(kdtree::BuildCounters& counters);

  std::size_t slices() const { return results_.size(); }
  /// At least so many.
  std::size_t slices_done() const { return done_.load(std::memory_order_acquire); }
  bool done() const { return slices_done() == results_.size(); }

  /// Of a slice that is done.
  const PassSlice& operator[](std::size_t slice) const {
    return *results_[slice].load(std::memory_order_acquire);
  }

  /// The pass behind this one, or null.
  std::atomic<SharedPass*> next{nullptr};

 private:
  void run(std::size_t slice, kdtree::BuildCounters& counters);

  Work work_;
  std::vector<std::atomic<PassSlice*>> results_;
  std::atomic<std::size_t> begun_{0};
  std::atomic<std::size_t> done_{0};
};

}  // namespace sightline::accel::lazy
