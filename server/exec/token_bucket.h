// A limit on how fast something is used.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace sightline::server::exec {

/// A bucket that fills at a rate, up to what flows in one second. What is taken may be more than is
/// in it: then nothing is given out until the debt is paid. So a request of any size is served, and
/// in the long run the rate holds. Threads: one at a time.
class TokenBucket {
 public:
  using Clock = std::chrono::steady_clock;

  /// The bucket is full at first. `rate`: per second, >= 1.
  TokenBucket(std::uint64_t rate, Clock::time_point now)
      : rate_(static_cast<double>(rate)), level_(rate_), filled_(now) {}

  /// Whether there is anything left, or no debt at least.
  bool open(Clock::time_point now) {
    fill(now);
    return level_ > 0;
  }
  /// Takes the amount in any case.
  void take(std::uint64_t amount) { level_ -= static_cast<double>(amount); }

  /// When open() will be true, from `now` on.
  std::chrono::milliseconds wait(Clock::time_point now) {
    if (open(now)) return {};
    return std::chrono::milliseconds(static_cast<std::int64_t>(-level_ / rate_ * 1e3) + 1);
  }
  /// Whether it is as good as new.
  bool full(Clock::time_point now) {
    fill(now);
    return level_ >= rate_;
  }

 private:
  void fill(Clock::time_point now) {
    level_ = std::min(rate_, level_ + rate_ * std::chrono::duration<double>(now - filled_).count());
    filled_ = now;
  }

  double rate_, level_;
  Clock::time_point filled_;
};

}  // namespace sightline::server::exec
