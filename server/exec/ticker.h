// A thread that does the same short work again and again.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace sightline::server::exec {

/// Runs work() every `period` until it is destroyed, on a thread of its own. work() must not throw.
class Ticker {
 public:
  Ticker(std::chrono::milliseconds period, std::function<void()> work);
  ~Ticker() = default;  // waits for work() that runs
  /// Runs work() at once, after one that runs now. Threads: any.
  void run_now();
  Ticker(const Ticker&) = delete;
  Ticker& operator=(const Ticker&) = delete;

 private:
  void run(const std::stop_token& stopped);

  const std::chrono::milliseconds period_;
  const std::function<void()> work_;
  std::mutex mutex_;
  bool now_ = false;
  std::condition_variable_any wake_;
  std::jthread thread_;  // last: uses the members above
};

}  // namespace sightline::server::exec
