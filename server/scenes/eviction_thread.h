// A thread that makes room for trees when they ask for it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "accel/kdtree/tree_memory.h"
#include "server/scenes/reclaim.h"

namespace sightline::server::scenes {

/// Evicts pieces of trees whenever a ray finds no room for a cell. Rays do not wait for it: they
/// search lists meanwhile.
class EvictionThread {
 public:
  /// Both outlive this object.
  EvictionThread(Reclaimer& reclaimer, accel::kdtree::TreeMemory& trees);
  ~EvictionThread();
  EvictionThread(const EvictionThread&) = delete;
  EvictionThread& operator=(const EvictionThread&) = delete;

 private:
  void run();

  Reclaimer& reclaimer_;
  accel::kdtree::TreeMemory& trees_;
  std::mutex mutex_;
  std::condition_variable stopping_;
  bool stop_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace sightline::server::scenes
