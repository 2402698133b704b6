// The keys by which clients get the descriptors of segments.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "server/segments/segment.h"

namespace sightline::server::segments {

/// Threads: any, for every member.
class HandoverKeys {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kBytes = 32;
  using Key = std::array<std::uint8_t, kBytes>;
  /// A key is good once, for this long: a client uses it at once.
  static constexpr std::chrono::seconds kGoodFor{10};

  /// A new key of a segment, which is not kept alive by it.
  Key add(const std::shared_ptr<const Segment>& segment, Clock::time_point now = Clock::now());
  /// The segment of a key, which is not good any more afterwards. Null: there is none; that takes
  /// as long for every key.
  std::shared_ptr<const Segment> take(std::span<const std::uint8_t, kBytes> key,
                                      Clock::time_point now = Clock::now());

  std::size_t size() const;

 private:
  struct Entry {
    Key key;
    std::weak_ptr<const Segment> segment;
    Clock::time_point until;
  };
  void forget_late(Clock::time_point now);

  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
};

}  // namespace sightline::server::segments
