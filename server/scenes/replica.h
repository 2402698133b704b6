// What a server that shares its scenes with others knows of them.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "proto/result.h"

namespace sightline::server::scenes {

/// Threads: any, for every member.
class Replica {
 public:
  using Clock = std::chrono::steady_clock;

  /// How old the answers to reads may be that name no revision. 0: however old.
  explicit Replica(std::chrono::milliseconds max_staleness = {}) : max_staleness_(max_staleness) {}

  /// The newest revisions of all scenes are known as of this time.
  void heard(Clock::time_point asked) { heard_.store(asked, std::memory_order_relaxed); }
  /// How long nothing was heard; at first, since the start.
  Clock::duration staleness() const {
    return Clock::now() - heard_.load(std::memory_order_relaxed);
  }
  /// Whether a read that names no revision may be answered. Errors: kUnavailable (STALE).
  Status fresh() const;

  /// The server ends: no write is tried again.
  void stop() { stopped_.store(true); }
  bool stopped() const { return stopped_.load(); }

  /// What has happened so far.
  struct Tallies {
    std::atomic<std::uint64_t> revisions_followed{0};  ///< Revisions of other servers, applied.
    std::atomic<std::uint64_t> scenes_reloaded{0};  ///< Because the log did not go back far enough.
    std::atomic<std::uint64_t> writes_repeated{0};  ///< Because others had committed first.
    std::atomic<std::uint64_t> writes_failed{0};    ///< After kMaxTries.
  };
  Tallies tallies;

 private:
  const std::chrono::milliseconds max_staleness_;
  std::atomic<Clock::time_point> heard_{Clock::now()};
  std::atomic<bool> stopped_{false};
};

}  // namespace sightline::server::scenes
