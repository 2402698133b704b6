// Frames of HTTP/2 as bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/net/frame_reader.h"

namespace sightline::tests {

inline constexpr std::string_view kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
inline constexpr std::uint8_t kPriority = 2, kServerPush = 5;

inline std::string big_endian(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i) & 0xff);
  return text;
}

inline std::string frame(std::uint8_t type, std::uint8_t flags, std::uint32_t stream,
                         std::string_view payload = {}) {
  std::string text = big_endian(static_cast<std::uint32_t>(payload.size()), 3);
  text += static_cast<char>(type);
  text += static_cast<char>(flags);
  text += big_endian(stream, 4);
  return text.append(payload);
}

inline std::string headers(std::uint32_t stream, std::size_t size = 20) {
  return frame(server::net::FrameHead::kHeaders, server::net::FrameHead::kEndHeaders, stream,
               std::string(size, 'f'));
}

inline std::string reset(std::uint32_t stream, std::uint32_t code) {
  return frame(server::net::FrameHead::kResetStream, 0, stream, big_endian(code, 4));
}

}  // namespace sightline::tests
