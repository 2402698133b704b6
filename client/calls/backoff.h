// How long to wait before the next attempt, and when to give up. Internal to the library.
#pragma once

#include <algorithm>
#include <chrono>

#include "client/result.h"

namespace sightline::client::calls {

/// The connection broke, or the server went; what was asked may be asked again if that is safe.
/// gRPC has no better name than unknown for a call whose connection was closed under it.
inline bool is_broken_connection(Code code) {
  return code == Code::kUnavailable || code == Code::kUnknown;
}

class Backoff {
 public:
  explicit Backoff(int attempts) : attempts_(attempts) {}

  /// After an attempt that came to something.
  void reset() {
    failed_ = 0;
    pause_ = kFirstPause;
  }
  /// Counts a failed attempt. False: it was the last one.
  bool again() { return ++failed_ < attempts_; }
  /// To wait before the next attempt.
  std::chrono::milliseconds pause() {
    const auto now = pause_;
    pause_ = std::min(2 * pause_, kLongestPause);
    return now;
  }

 private:
  static constexpr std::chrono::milliseconds kFirstPause{100};
  static constexpr std::chrono::milliseconds kLongestPause{2000};

  int attempts_;
  int failed_ = 0;
  std::chrono::milliseconds pause_ = kFirstPause;
};

}  // namespace sightline::client::calls
