// Why a connection is ended.
#pragma once

#include <array>
#include <cstdint>

namespace sightline::server::net {

/// Why a connection is ended.
enum class Abuse : std::uint8_t {
  kResets,   ///< Calls that are given up before they are answered.
  kStreams,  ///< More calls at a time than the server takes.
  kHeaders,  ///< Fields of a call in several frames, or too large ones.
  kFrames,   ///< Frames that have no content.
};
inline constexpr std::array kAbuses{Abuse::kResets, Abuse::kStreams, Abuse::kHeaders,
                                    Abuse::kFrames};

/// The name in metrics and the log.
constexpr const char* abuse_name(Abuse abuse) {
  constexpr std::array kNames{"resets", "streams", "headers", "frames"};
  return kNames[static_cast<std::size_t>(abuse)];
}

}  // namespace sightline::server::net
