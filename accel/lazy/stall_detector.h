// Waits for other threads without taking their processor time, and detects that they are stopped.
#pragma once

#include <chrono>
#include <cstdint>
#include <thread>

namespace sightline::accel::lazy {

/// One object for each wait. Its clock decides which thread does a piece of work, never the result.
class Patience {
 public:
  /// Lets other threads run. Returns false if `progress` has not changed for kStall.
  bool wait(std::uint64_t progress) {
    const auto now = std::chrono::steady_clock::now();
    if (progress != progress_ || waits_ == 0) {
      progress_ = progress;
      since_ = now;
    } else if (now - since_ > kStall) {
      return false;
    }
    if (++waits_ <= kYields) {
      std::this_thread::yield();
    } else {
      std::this_thread::sleep_for(kNap);
    }
    return true;
  }

 private:
  static constexpr int kYields = 16;
  static constexpr std::chrono::microseconds kNap{50};
  /// Longer than a thread is kept waiting for a core by a few others.
  static constexpr std::chrono::milliseconds kStall{20};

  std::uint64_t progress_ = 0;
  std::chrono::steady_clock::time_point since_;
  int waits_ = 0;
};

}  // namespace sightline::accel::lazy
