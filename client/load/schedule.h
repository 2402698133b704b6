// When requests are due: by a rate, or as soon as one is answered.
#pragma once

#include <cstdint>
#include <optional>

#include "client/load/clock.h"

namespace sightline::client::load {

/// Open loop: request k is due at k / rate, whatever the server does, and its latency counts from
/// then. So a server that stalls is charged for all requests that should have been sent meanwhile.
/// Closed loop: each worker sends its next request when the one before is answered.
class Schedule {
 public:
  static Schedule closed() { return Schedule(0); }
  /// `rate` is in requests per second, above 0.
  static Schedule open(double rate) { return Schedule(rate); }

  bool is_open() const { return rate_ > 0; }
  double rate() const { return rate_; }
  /// When the request is due, since the start of the run; nothing in a closed loop.
  std::optional<Nanoseconds> due(std::uint64_t request) const {
    if (!is_open()) return std::nullopt;
    return from_seconds(static_cast<double>(request) / rate_);
  }

 private:
  explicit Schedule(double rate) : rate_(rate) {}
  double rate_;
};

}  // namespace sightline::client::load
