// The first error of tasks that run in parallel.
#pragma once

#include <atomic>
#include <mutex>
#include <utility>

#include "proto/result.h"
#include "scenegraph/query/or_error.h"

namespace sightline::scenegraph::query {

/// The first error of parallel tasks. They must not throw: oneTBB would cancel all that runs below
/// the loop, such as the passes of a cell that another task builds, which would be taken for whole.
/// Threads: any, for every member.
class FirstError {
 public:
  /// Runs work(), and keeps what stops it.
  template <class Work>
  void run(const Work& work) {
    Status done = or_error([&] {
      work();
      return Status();
    });
    if (done) return;
    const std::lock_guard lock(mutex_);
    if (!happened_.load(std::memory_order_relaxed)) first_ = std::move(done);
    happened_.store(true, std::memory_order_release);
  }

  bool happened() const { return happened_.load(std::memory_order_relaxed); }
  /// The first error, once the tasks have ended.
  const Status& status() const { return first_; }

 private:
  std::atomic<bool> happened_{false};
  std::mutex mutex_;
  Status first_;
};

}  // namespace sightline::scenegraph::query
