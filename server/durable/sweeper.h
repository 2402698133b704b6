// Removes stored meshes that nothing names any more.
#pragma once

#include <atomic>
#include <chrono>

#include "server/durable/store_catalog.h"

namespace sightline::server::durable {

/// A mesh stays this long after it was stored or asked for: its client may be about to use it.
inline constexpr std::chrono::minutes kBlobGrace{30};
/// The time between two sweeps.
inline constexpr std::chrono::minutes kSweepEvery{5};

/// Threads: any.
class Sweeper {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Sweeper(const StoreParts& parts) : parts_(parts) {}

  /// Begins a sweep on a background worker if one is due. Call it from time to time.
  void tick();

 private:
  void sweep();

  const StoreParts parts_;
  std::atomic<Clock::time_point> last_{Clock::now()};
};

}  // namespace sightline::server::durable
