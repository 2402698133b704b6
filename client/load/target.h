// What a run sends its requests to, and what became of one request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>

namespace sightline::client::load {

struct Outcome {
  enum class State : std::uint8_t {
    kAnswered,
    kRefused,    ///< for a limit of the server (kResourceExhausted)
    kFailed,     ///< any other error
    kCancelled,  ///< by the end of the run
  };
  State state = State::kAnswered;
  bool is_update = false;  ///< it changed the scene; no rays
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;
  /// See CastReport.
  std::uint64_t queue_us = 0, build_us = 0, trace_us = 0;
  std::string error;  ///< the message of a refusal or failure
};

class Target {
 public:
  virtual ~Target() = default;
  /// Sends one request and waits for its answer. Called by several workers at a time, each with its
  /// own number from 0 on.
  virtual Outcome send(std::size_t worker, std::uint64_t request, const std::stop_token& stop) = 0;
};

}  // namespace sightline::client::load
