// What stops the work of a batch, as an error.
#pragma once

#include <atomic>
#include <mutex>
#include <new>
#include <utility>

#include "accel/result.h"
#include "scenegraph/model/mesh_source.h"

namespace sightline::scenegraph::query {

/// What work() returns; kResourceExhausted if it throws std::bad_alloc, and the error of
/// model::MeshUnreadable. What was built until then remains, and the same work may succeed later.
template <class Work>
auto or_error(const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{Code::kResourceExhausted, "no memory is left for the trees that the rays need",
                 "OUT_OF_MEMORY"};
  } catch (const model::MeshUnreadable& thrown) {
    return thrown.error();
  }
}

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
  /// Once the tasks have ended.
  const Status& status() const { return first_; }

 private:
  std::atomic<bool> happened_{false};
  std::mutex mutex_;
  Status first_;
};

}  // namespace sightline::scenegraph::query
