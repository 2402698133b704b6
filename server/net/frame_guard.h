// Bounds what the peer of an HTTP/2 connection makes a server keep and do.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/net/abuse.h"
#include "server/net/frame_reader.h"

namespace sightline::server::net {

/// An allowance that fills with time and with work done.
class Allowance {
 public:
  using Clock = std::chrono::steady_clock;

  Allowance(double most, double per_second, Clock::time_point now)
      : most_(most), per_second_(per_second), left_(most), filled_(now) {}

  /// False: there is less left than that.
  bool spend(double amount, Clock::time_point now);
  void earn(double amount) { left_ = left_ + amount < most_ ? left_ + amount : most_; }

 private:
  const double most_, per_second_;
  double left_;
  Clock::time_point filled_;
};

/// Reads the heads of the frames of one connection, and judges its client. A good client stays far
/// below every limit; docs/decisions/operations.md (HTTP/2 floods) derives them. Threads: one at a
/// time.
class FrameGuard {
 public:
  using Clock = Allowance::Clock;

  /// Calls at a time before the client has acknowledged the server's settings: it may not know its
  /// limit.
  static constexpr std::size_t kFirstStreams = 100;
  /// Bytes of fields until that acknowledgement: gRPC's own limit (8 KiB a call) holds only
  /// afterwards.
  static constexpr std::size_t kFirstFields = std::size_t{64} << 10;
  static constexpr std::size_t kMaxFields = std::size_t{16} << 10;  ///< Bytes, of one call.
  /// Calls that a client may give up before they are answered: at once, and a second. Each call
  /// answered allows for another.
  static constexpr double kResets = 200, kResetsPerSecond = 2'000;
  /// Frames without a use of their own: at once, and a second. A frame of an answer allows for
  /// kFramesPerAnswer more.
  static constexpr double kFrames = 20'000, kFramesPerSecond = 20'000, kFramesPerAnswer = 4;
  /// A frame that wants an answer or has fields to decode counts as this many.
  static constexpr double kDear = 10;
  /// PING frames: at once, and a second. Each frame with an answer or a window allows for another.
  static constexpr double kPings = 16, kPingsPerSecond = 1;
  /// A DATA frame of fewer bytes that does not end a message's stream counts as a frame without a
  /// use.
  static constexpr std::size_t kSmallData = 64;

  /// `max_streams`: calls at a time that the server's settings allow.
  FrameGuard(std::size_t max_streams, Clock::time_point now);

  struct Verdict {
    Abuse abuse;
    std::size_t at;  ///< What was received from here on begins with a whole frame.
  };
  /// Reads bytes from the client. With a verdict the connection has to end, and bytes from `at` on
  /// must not be handled; nothing may be received afterwards.
  std::optional<Verdict> receive(std::span<const std::uint8_t> bytes, Clock::time_point now);
  /// Reads bytes to the client before it can have them.
  void send(std::span<const std::uint8_t> bytes, Clock::time_point now);

 private:
  std::optional<Abuse> judge(const FrameHead& head, Clock::time_point now);
  std::optional<Abuse> judge_fields(const FrameHead& head, Clock::time_point now);
  void answer(const FrameHead& head, Clock::time_point now);
  /// Closes a stream. Returns whether it was open.
  bool close(std::uint32_t stream);

  const std::size_t max_streams_;
  FrameReader received_, sent_{0};
  std::vector<std::uint32_t> open_;  // ascending
  std::uint32_t last_stream_ = 0;
  std::size_t settings_sent_ = 0;
  bool acknowledged_ = false;
  std::size_t first_fields_ = 0;
  Allowance resets_, frames_, pings_;
  bool too_many_resets_ = false;  // by what the server gave up
  std::optional<Abuse> abuse_;    // in a frame that began in earlier bytes
};

}  // namespace sightline::server::net
