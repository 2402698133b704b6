// A clock that stands until it is moved, so that times in tests are exact.
#pragma once

#include <algorithm>
#include <atomic>

#include "client/load/clock.h"

namespace sightline::tests {

/// Sleeping moves it. Threads: any may read, one may move it.
class FakeClock final : public client::load::Clock {
 public:
  client::load::Nanoseconds now() override { return now_.load(); }
  void sleep_until(client::load::Nanoseconds time, const std::stop_token&) override {
    now_ = std::max(now(), time);
  }
  void advance(client::load::Nanoseconds time) { now_ = now() + time; }

 private:
  std::atomic<client::load::Nanoseconds> now_{std::chrono::hours(1)};
};

}  // namespace sightline::tests
