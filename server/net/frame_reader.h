// Finds the frames in one direction of an HTTP/2 connection.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sightline::server::net {

/// What stands before a frame's payload (RFC 9113, 4.1).
struct FrameHead {
  enum Type : std::uint8_t {
    kData = 0,
    kHeaders = 1,
    kResetStream = 3,
    kSettings = 4,
    kPing = 6,
    kGoAway = 7,
    kWindowUpdate = 8,
    kContinuation = 9
  };
  static constexpr std::uint8_t kAck = 1, kEndStream = 1, kEndHeaders = 4;

  std::uint32_t size = 0;  ///< Bytes of the payload.
  std::uint8_t type = 0, flags = 0;
  std::uint32_t stream = 0;
  std::uint32_t error = 0;  ///< The code that the payload of a kResetStream frame is.

  bool has(std::uint8_t flag) const { return (flags & flag) != 0; }
};

/// Takes the bytes in pieces of any size and keeps none of them but an unfinished head. Threads:
/// one at a time.
class FrameReader {
 public:
  /// `skipped`: bytes before the first frame.
  explicit FrameReader(std::size_t skipped) : skip_(skipped) {}

  /// Calls on_frame(head, begin) for every frame whose head ends in these bytes. `begin`: where the
  /// frame begins in them; less than 0 for one that began before them. It returns whether to go on.
  template <class OnFrame>
  void read(std::span<const std::uint8_t> bytes, OnFrame on_frame);

  /// Bytes to come before the next frame begins; 0 also inside of a head.
  std::size_t left_of_payload() const { return skip_; }

 private:
  static constexpr std::size_t kHead = 9, kCode = 4;

  static std::uint32_t number(const std::uint8_t* at, std::size_t bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | at[i];
    return value;
  }
  /// Decodes a whole head, with the error code where there is one.
  static FrameHead decode(const std::uint8_t* at, std::size_t size) {
    return {.size = number(at, 3),
            .type = at[3],
            .flags = at[4],
            .stream = number(at + 5, 4) & 0x7fff'ffff,
            .error = size > kHead ? number(at + kHead, kCode) : 0};
  }
  static std::size_t wanted(const std::uint8_t* head, std::size_t have) {
    const bool code =
        have >= kHead && head[3] == FrameHead::kResetStream && number(head, 3) == kCode;
    return code ? kHead + kCode : kHead;
  }

  std::size_t skip_;  // bytes before the next head
  std::array<std::uint8_t, kHead + kCode> head_{};
  std::size_t have_ = 0;  // bytes in head_
};

template <class OnFrame>
void FrameReader::read(std::span<const std::uint8_t> bytes, OnFrame on_frame) {
  std::size_t at = 0;
  while (at < bytes.size()) {
    const std::size_t skipped = std::min(skip_, bytes.size() - at);
    at += skipped;
    skip_ -= skipped;
    if (at == bytes.size()) return;
    const std::ptrdiff_t begin =
        static_cast<std::ptrdiff_t>(at) - static_cast<std::ptrdiff_t>(have_);
    for (std::size_t want = wanted(head_.data(), have_); have_ < want;
         want = wanted(head_.data(), have_)) {
      if (at == bytes.size()) return;
      const std::size_t taken = std::min(want - have_, bytes.size() - at);
      std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), taken,
                  head_.begin() + static_cast<std::ptrdiff_t>(have_));
      have_ += taken;
      at += taken;
    }
    const FrameHead head = decode(head_.data(), have_);
    skip_ = head.size - (have_ - kHead);
    have_ = 0;
    if (!on_frame(head, begin)) return;
  }
}

}  // namespace sightline::server::net
