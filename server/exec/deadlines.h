// Flags that become true at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <stop_token>
#include <thread>
#include <utility>

namespace sightline::server::exec {

/// Sets flags when their time has come, on a thread of its own. Threads: any, for every member.
class Deadlines {
 public:
  using Clock = std::chrono::steady_clock;

  Deadlines();
  Deadlines(const Deadlines&) = delete;
  Deadlines& operator=(const Deadlines&) = delete;

  /// While it lives, its flag becomes true at its time. Once it is gone, nothing touches the flag.
  class Alarm {
   public:
    Alarm() = default;
    Alarm(Alarm&& other) noexcept { *this = std::move(other); }
    Alarm& operator=(Alarm&& other) noexcept {
      std::swap(deadlines_, other.deadlines_);
      std::swap(key_, other.key_);
      return *this;
    }
    ~Alarm();

   private:
    friend class Deadlines;
    using Key = std::pair<Clock::time_point, std::atomic<bool>*>;
    Alarm(Deadlines& deadlines, Key key) : deadlines_(&deadlines), key_(key) {}

    Deadlines* deadlines_ = nullptr;
    Key key_;
  };

  /// A flag has one alarm at a time. A time in the past comes at once.
  [[nodiscard]] Alarm set(Clock::time_point at, std::atomic<bool>& flag);

 private:
  void run(const std::stop_token& stopped);
  void remove(const Alarm::Key& key);

  std::mutex mutex_;
  std::condition_variable_any earlier_;  // the earliest time has changed
  std::set<Alarm::Key> alarms_;
  std::jthread thread_;  // last: uses the members above
};

}  // namespace sightline::server::exec
