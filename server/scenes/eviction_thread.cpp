// Rounds of eviction, with pauses.
#include "server/scenes/eviction_thread.h"

#include <spdlog/spdlog.h>

#include <chrono>

#include "proto/result.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::scenes {
namespace {

/// The pause between two rounds, so that trees that do not fit are not built and evicted all the
/// time.
constexpr std::chrono::milliseconds kPause{10};

}  // namespace

EvictionThread::EvictionThread(Reclaimer& reclaimer, accel::kdtree::TreeMemory& trees)
    : reclaimer_(reclaimer), trees_(trees), thread_([this] { run(); }) {}

EvictionThread::~EvictionThread() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  stopping_.notify_all();
  trees_.request_eviction();
  thread_.join();
}

void EvictionThread::run() {
  for (;;) {
    trees_.wait_for_request();
    std::unique_lock lock(mutex_);
    if (stop_) return;
    lock.unlock();
    const Status evicted = exec::to_status([this]() -> Status {
      reclaimer_.evict_to_low_water();
      return {};
    });
    if (!evicted) spdlog::error("event=no_eviction error={}", evicted.error().message);
    lock.lock();
    if (stopping_.wait_for(lock, kPause, [this] { return stop_; })) return;
  }
}

}  // namespace sightline::server::scenes
