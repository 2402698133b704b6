// The connections that were ended for what their clients sent.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "server/net/abuse.h"

namespace sightline::server::net {

/// Counts and logs connections that were ended. Threads: any, for every member.
class EndedConnections {
 public:
  /// Logs at most a line a second.
  void add(Abuse abuse, const std::string& peer);
  /// The addresses of those that were ended since the last call, at most kMaxAddresses.
  std::vector<std::string> take_addresses();
  static constexpr std::size_t kMaxAddresses = 1'000;
  std::uint64_t count(Abuse abuse) const { return counts_[static_cast<std::size_t>(abuse)].load(); }

 private:
  std::array<std::atomic<std::uint64_t>, kAbuses.size()> counts_{};
  std::mutex mutex_;
  std::chrono::steady_clock::time_point logged_;  // protected by mutex_
  std::uint64_t unlogged_ = 0;                    // protected by mutex_
  std::vector<std::string> addresses_;            // protected by mutex_
};

}  // namespace sightline::server::net
