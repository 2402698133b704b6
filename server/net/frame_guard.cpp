// Bounds what the peer of an HTTP/2 connection makes a server keep and do.
#include "server/net/frame_guard.h"

#include <algorithm>

namespace sightline::server::net {
namespace {

constexpr std::size_t kPreface = 24;  // RFC 9113, 3.4

}  // namespace

bool Allowance::spend(double amount, Clock::time_point now) {
  if (left_ < amount) {
    earn(per_second_ * std::chrono::duration<double>(now - filled_).count());
    filled_ = now;
  }
  if (left_ < amount) return false;
  left_ -= amount;
  return true;
}

FrameGuard::FrameGuard(std::size_t max_streams, Clock::time_point now)
    : max_streams_(max_streams),
      received_(kPreface),
      resets_(kResets, kResetsPerSecond, now),
      frames_(kFrames, kFramesPerSecond, now),
      pings_(kPings, kPingsPerSecond, now) {}

std::optional<FrameGuard::Verdict> FrameGuard::receive(std::span<const std::uint8_t> bytes,
                                                       Clock::time_point now) {
  std::optional<std::size_t> end;
  received_.read(bytes, [&](const FrameHead& head, std::ptrdiff_t begin) {
    if (!abuse_) abuse_ = judge(head, now);
    // A frame cannot be held back once a part of its head was handed on.
    if (!abuse_ || begin < 0) return true;
    end = static_cast<std::size_t>(begin);
    return false;
  });
  if (!abuse_ || !end) return std::nullopt;
  return Verdict{*abuse_, *end};
}

std::optional<Abuse> FrameGuard::judge(const FrameHead& head, Clock::time_point now) {
  if (too_many_resets_) return Abuse::kResets;
  double cost = 1;
  switch (head.type) {
    case FrameHead::kHeaders:
    case FrameHead::kContinuation:
      return judge_fields(head, now);
    case FrameHead::kResetStream:
      if (close(head.stream) && !resets_.spend(1, now)) return Abuse::kResets;
      break;
    case FrameHead::kData:
      if (head.size >= kSmallData || head.has(FrameHead::kEndStream)) return std::nullopt;
      break;
    case FrameHead::kSettings:
      if (!head.has(FrameHead::kAck)) {
        cost = kDear + head.size / 64.0;
      } else if (settings_sent_ > 0) {
        acknowledged_ = true;
      }
      break;
    case FrameHead::kPing:
      // gRPC ends the connection at the fourth, but pays for each until it has read them all.
      if (!head.has(FrameHead::kAck) && !pings_.spend(1, now)) return Abuse::kFrames;
      break;
    case FrameHead::kGoAway:
      cost = kDear;
      break;
    default:
      break;
  }
  return frames_.spend(cost, now) ? std::nullopt : std::optional(Abuse::kFrames);
}

std::optional<Abuse> FrameGuard::judge_fields(const FrameHead& head, Clock::time_point now) {
  // A call's fields fit one frame by far, as gRPC takes no more than 8 KiB of them.
  if (head.type == FrameHead::kContinuation || !head.has(FrameHead::kEndHeaders) ||
      head.size > kMaxFields)
    return Abuse::kHeaders;
  if (head.stream <= last_stream_ || head.stream % 2 == 0)
    return frames_.spend(kDear, now) ? std::nullopt : std::optional(Abuse::kFrames);
  last_stream_ = head.stream;
  if (!acknowledged_) first_fields_ += head.size;
  if (!acknowledged_ && first_fields_ > kFirstFields) return Abuse::kHeaders;
  open_.push_back(head.stream);
  const std::size_t most = acknowledged_ ? max_streams_ : std::max(max_streams_, kFirstStreams);
  return open_.size() > most ? std::optional(Abuse::kStreams) : std::nullopt;
}

void FrameGuard::send(std::span<const std::uint8_t> bytes, Clock::time_point now) {
  sent_.read(bytes, [&](const FrameHead& head, std::ptrdiff_t) {
    answer(head, now);
    return true;
  });
}

void FrameGuard::answer(const FrameHead& head, Clock::time_point now) {
  switch (head.type) {
    case FrameHead::kData:
    case FrameHead::kHeaders:
      frames_.earn(kFramesPerAnswer);
      pings_.earn(1);
      if (head.has(FrameHead::kEndStream) && close(head.stream)) resets_.earn(1);
      break;
    case FrameHead::kResetStream:
      // The client can make the server do so, for example with frames that have errors.
      if (close(head.stream) && head.error != 0 && !resets_.spend(1, now)) too_many_resets_ = true;
      break;
    case FrameHead::kSettings:
      if (!head.has(FrameHead::kAck)) ++settings_sent_;
      break;
    case FrameHead::kWindowUpdate:
      pings_.earn(1);
      break;
    default:
      break;
  }
}

bool FrameGuard::close(std::uint32_t stream) {
  const auto found = std::lower_bound(open_.begin(), open_.end(), stream);
  if (found == open_.end() || *found != stream) return false;
  open_.erase(found);
  return true;
}

}  // namespace sightline::server::net
