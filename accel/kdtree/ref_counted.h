// Objects with several owners.
#pragma once

#include <atomic>

namespace sightline::accel::kdtree {

/// An object with several owners, freed by the one that leaves last. The thread that made it has
/// joined it. Threads: any; a thread joins only while it knows that another owner has not left.
class RefCounted {
 public:
  void join() { users_.fetch_add(1, std::memory_order_relaxed); }
  void leave() {
    if (users_.fetch_sub(1, std::memory_order_acq_rel) == 1) delete this;
  }
  RefCounted(const RefCounted&) = delete;
  RefCounted& operator=(const RefCounted&) = delete;

 protected:
  RefCounted() = default;
  virtual ~RefCounted() = default;

 private:
  std::atomic<int> users_{1};
};

}  // namespace sightline::accel::kdtree
