// The time that a run goes by: the machine's, or one that tests set.
#pragma once

#include <chrono>
#include <stop_token>

namespace sightline::client::load {

using Nanoseconds = std::chrono::nanoseconds;

inline double seconds_of(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }
inline double milliseconds_of(Nanoseconds time) { return seconds_of(time) * 1e3; }
inline Nanoseconds from_seconds(double seconds) {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(seconds));
}

/// Threads: any.
class Clock {
 public:
  virtual ~Clock() = default;
  /// The time since a fixed moment. It never goes back.
  virtual Nanoseconds now() = 0;
  /// Returns at that time, or soon after a stop is requested.
  virtual void sleep_until(Nanoseconds time, const std::stop_token& stop) = 0;
};

class SteadyClock final : public Clock {
 public:
  Nanoseconds now() override;
  /// Wakes within microseconds, where the system's default is tens of them.
  void sleep_until(Nanoseconds time, const std::stop_token& stop) override;
};

}  // namespace sightline::client::load
