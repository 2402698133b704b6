// The attempts of one call: which failures are worth another one, and when. Internal to the
// library.
#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <cstdint>
#include <optional>

#include "client/calls/connection.h"
#include "client/calls/retries.h"

namespace sightline::client::calls {

/// What is repeated beside what gRPC itself repeats.
enum class Repeat : std::uint8_t {
  kNothing,
  kRefusals,           ///< what a server refuses for now (Retries)
  kRefusalsAndBreaks,  ///< and what a broken connection has left without an answer
};

class Attempts {
 public:
  /// Without a timeout attempts have no deadline.
  Attempts(std::optional<std::chrono::milliseconds> timeout, Repeat repeat);

  /// Of the next attempt.
  const Retries::Deadline& deadline() const { return deadline_; }
  /// How long to wait before the next attempt. Nothing: the status stands.
  std::optional<std::chrono::milliseconds> pause(const grpc::Status& status);

 private:
  std::optional<std::chrono::milliseconds> timeout_;
  Repeat repeat_;
  Backoff backoff_;
  Retries::Deadline deadline_;
  std::optional<Retries> retries_;
};

}  // namespace sightline::client::calls
