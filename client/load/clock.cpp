// The machine's steady clock, with sleeps that end on time.
#include "client/load/clock.h"

#include <sys/prctl.h>

#include <algorithm>
#include <thread>

namespace sightline::client::load {

Nanoseconds SteadyClock::now() { return std::chrono::steady_clock::now().time_since_epoch(); }

void SteadyClock::sleep_until(Nanoseconds time, const std::stop_token& stop) {
  constexpr Nanoseconds kStep = std::chrono::milliseconds(50);  // until a stop is noticed
  thread_local const bool kIsPrecise = ::prctl(PR_SET_TIMERSLACK, 1UL) == 0;
  static_cast<void>(kIsPrecise);
  while (!stop.stop_requested()) {
    const Nanoseconds wake = std::min(time, now() + kStep);
    std::this_thread::sleep_until(std::chrono::steady_clock::time_point(wake));
    if (wake == time) return;
  }
}

}  // namespace sightline::client::load
