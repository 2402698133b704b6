// Sets flags, the earliest first.
#include "server/exec/deadlines.h"

namespace sightline::server::exec {

Deadlines::Alarm::~Alarm() {
  if (deadlines_ != nullptr) deadlines_->remove(key_);
}

Deadlines::Deadlines() : thread_([this](const std::stop_token& stopped) { run(stopped); }) {}

Deadlines::Alarm Deadlines::set(Clock::time_point at, std::atomic<bool>& flag) {
  const Alarm::Key key{at, &flag};
  {
    const std::lock_guard lock(mutex_);
    alarms_.insert(key);
    if (*alarms_.begin() != key) return Alarm(*this, key);
  }
  earlier_.notify_one();
  return Alarm(*this, key);
}

void Deadlines::remove(const Alarm::Key& key) {
  const std::lock_guard lock(mutex_);
  alarms_.erase(key);
}

void Deadlines::run(const std::stop_token& stopped) {
  std::unique_lock lock(mutex_);
  while (!stopped.stop_requested()) {
    const Clock::time_point now = Clock::now();
    while (!alarms_.empty() && alarms_.begin()->first <= now) {
      alarms_.begin()->second->store(true, std::memory_order_relaxed);
      alarms_.erase(alarms_.begin());
    }
    if (alarms_.empty()) {
      earlier_.wait(lock, stopped, [&] { return !alarms_.empty(); });
      continue;
    }
    const Clock::time_point next = alarms_.begin()->first;
    earlier_.wait_until(lock, stopped, next,
                        [&] { return !alarms_.empty() && alarms_.begin()->first < next; });
  }
}

}  // namespace sightline::server::exec
