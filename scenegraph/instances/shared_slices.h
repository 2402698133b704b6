// Work in slices, shared by any number of threads. No thread depends on another.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "accel/lazy/stall_detector.h"

namespace sightline::scenegraph::instances {

/// One result for each slice. Threads: all members, any.
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
  /// Of a completed slice.
  const Result& operator[](std::size_t slice) const {
    return *results_[slice].load(std::memory_order_acquire);
  }

  /// Returns when all slices are complete. make(slice) returns a unique_ptr<const Result> and must
  /// give equal results at each call: if two threads complete a slice, the first result is kept.
  /// With `wait`, waits for slices of other threads while these make progress, and then completes
  /// them itself. Throws what `make` throws.
  template <class Make>
  void complete(bool wait, const Make& make) {
    if (done() == size()) return;
    for (;;) {
      const std::size_t slice = begun_.fetch_add(1, std::memory_order_relaxed);
      if (slice >= size()) break;
      run(slice, make);
    }
    for (int stalls = 0; wait && done() < size() && stalls < kStalls; ++stalls) {
      for (accel::lazy::StallDetector stall_detector;
           done() < size() && stall_detector.wait(done());)
        continue;
    }
    for (std::size_t slice = 0; slice < size(); ++slice) run(slice, make);
  }

 private:
  // One slice may take several times longer than the stall timeout.
  static constexpr int kStalls = 5;

  std::size_t done() const { return done_.load(std::memory_order_acquire); }

  template <class Make>
  void run(std::size_t slice, const Make& make) {
    if (results_[slice].load(std::memory_order_acquire) != nullptr) return;
    std::unique_ptr<const Result> made = make(slice);
    const Result* none = nullptr;
    if (!results_[slice].compare_exchange_strong(none, made.get(), std::memory_order_acq_rel))
      return;
    (void)made.release();
    done_.fetch_add(1, std::memory_order_release);
  }

  std::vector<std::atomic<const Result*>> results_;
  std::atomic<std::size_t> begun_{0}, done_{0};
};

}  // namespace sightline::scenegraph::instances
