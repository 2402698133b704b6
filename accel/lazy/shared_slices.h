// Work in slices, shared by any number of threads. No thread depends on another.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "accel/lazy/stall_detector.h"

namespace sightline::accel::lazy {

/// One result for each slice. `make(slice)` returns a unique_ptr<const Result> and must give equal
/// results at each call: if two threads make a slice, the first result is kept. All members throw
/// what `make` throws. Threads: all members, any.
template <class Result>
class SharedSlices {
 public:
  explicit SharedSlices(std::size_t slices) : results_(slices) {}
  ~SharedSlices() {
    for (auto& result : results_) delete result.load(std::memory_order_relaxed);
  }
  SharedSlices(const SharedSlices&) = delete;
  SharedSlices& operator=(const SharedSlices&) = delete;

  std::size_t size() const { return results_.size(); }
  /// A lower bound on the number of slices that are done.
  std::size_t size_done() const { return done_.load(std::memory_order_acquire); }
  bool done() const { return size_done() == size(); }

  /// Of a slice that is done.
  const Result& operator[](std::size_t slice) const {
    return *results_[slice].load(std::memory_order_acquire);
  }

  /// Makes slices that no thread has begun until none is left. Returns how many. Never waits.
  template <class Make>
  std::size_t help(const Make& make) {
    std::size_t helped = 0;
    // Read before it is incremented: help may be called any number of times.
    while (begun_.load(std::memory_order_relaxed) < size()) {
      const std::size_t slice = begun_.fetch_add(1, std::memory_order_relaxed);
      if (slice >= size()) break;
      run(slice, make);
      ++helped;
    }
    return helped;
  }

  /// Returns when all slices are done. Helps, then waits for slices of other threads until these
  /// have made no progress `stalls` times (0: does not wait), then makes the rest itself.
  template <class Make>
  void complete(int stalls, const Make& make) {
    help(make);
    for (; stalls > 0 && !done(); --stalls) {
      for (StallDetector stall_detector; !done() && stall_detector.wait(size_done());) continue;
    }
    if (!done()) finish(make);
  }

  /// Makes also slices that other threads have begun and not finished. All slices are done then,
  /// even if done() does not say so yet. Never waits.
  template <class Make>
  void finish(const Make& make) {
    help(make);
    for (std::size_t slice = 0; slice < size(); ++slice) run(slice, make);
  }

 private:
  template <class Make>
  void run(std::size_t slice, const Make& make) {
    if (results_[slice].load(std::memory_order_acquire) != nullptr) return;
    std::unique_ptr<const Result> made = make(slice);
    const Result* none = nullptr;
    if (!results_[slice].compare_exchange_strong(none, made.get(), std::memory_order_acq_rel))
      return;
    (void)made.release();
    done_.fetch_add(1, std::memory_order_acq_rel);
  }

  std::vector<std::atomic<const Result*>> results_;
  std::atomic<std::size_t> begun_{0}, done_{0};
};

}  // namespace sightline::accel::lazy
