// A thread that does the same short work again and again.
#include "server/exec/ticker.h"

#include <utility>

namespace sightline::server::exec {

Ticker::Ticker(std::chrono::milliseconds period, std::function<void()> work)
    : period_(period),
      work_(std::move(work)),
      thread_([this](const std::stop_token& stopped) { run(stopped); }) {}

void Ticker::run_now() {
  const std::lock_guard lock(mutex_);
  now_ = true;
  wake_.notify_all();
}

void Ticker::run(const std::stop_token& stopped) {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait_for(lock, stopped, period_, [this] { return now_; });
    if (stopped.stop_requested()) return;
    now_ = false;
    lock.unlock();
    work_();
    lock.lock();
  }
}

}  // namespace sightline::server::exec
