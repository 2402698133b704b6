// Work in slices that any number of threads do together, and none depends on another.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "accel/lazy/stall_detector.h"

namespace sightline::scenegraph::instances {

/// What is made of each slice, once. Threads: all members, any.
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
  /// Of a slice that is done.
  const Result& operator[](std::size_t slice) const {
    return *results_[slice].load(std::memory_order_acquire);
  }

  /// Returns when all are done. make(slice) returns a unique_ptr<const Result>, always an equal
  /// one: if two threads do a slice, the first result is kept. What others have begun is waited for
  /// as long as they get on, if `wait`; then it is done here. Throws what `make` throws.
  template <class Make>
  void complete(bool wait, const Make& make) {
    if (done() == size()) return;
    for (;;) {
      const std::size_t slice = begun_.fetch_add(1, std::memory_order_relaxed);
      if (slice >= size()) break;
      run(slice, make);
    }
    for (int stalls = 0; wait && done() < size() && stalls < kStalls; ++stalls) {
      for (accel::lazy::Patience patience; done() < size() && patience.wait(done());) continue;
    }
    for (std::size_t slice = 0; slice < size(); ++slice) run(slice, make);
  }

 private:
  // A slice may take several times as long as it takes to think that others have stopped.
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
