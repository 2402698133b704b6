// Waiting for other threads without burning their time, and noticing when they have stopped.
#pragma once

#include <chrono>
#include <cstdint>
#include <thread>

namespace sightline::accel::lazy {

/// Used anew for every wait. Its clock decides who does a piece of work, never what comes of it.
class StallDetector {
 public:
  /// Lets others run. False: `progress` has been the same for kStallTimeout.
  bool wait(std::uint64_t progress) {
    const auto now = std::chrono::steady_clock::now();
    if (progress != progress_ || waits_ == 0) {
      progress_ = progress;
      since_ = now;
    } else if (now - since_ > kStallTimeout) {
      return false;
    }
    if (++waits_ <= kYields) {
      std::this_thread::yield();
    } else {
      std::this_thread::sleep_for(kSleep);
    }
    return true;
  }

 private:
  static constexpr int kYields = 16;
  static constexpr std::chrono::microseconds kSleep{50};
  /// Longer than a thread is kept waiting for a core by a few others.
  static constexpr std::chrono::milliseconds kStallTimeout{20};

  std::uint64_t progress_ = 0;
  std::chrono::steady_clock::time_point since_;
  int waits_ = 0;
};

}  // namespace sightline::accel::lazy
