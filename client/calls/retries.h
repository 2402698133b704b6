// Repeating what a server refuses for now, and says when to repeat. Internal to the library.
#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <optional>
#include <stop_token>

namespace sightline::client::calls {

/// The time after which the server says that the call may be repeated. Nothing: the status is no
/// refusal that passes.
std::optional<std::chrono::milliseconds> retry_delay(const grpc::Status& status);

/// The retries of one operation, call after call. After a minute of waiting without progress, or if
/// the deadline does not leave the time, the refusal stands.
class Retries {
 public:
  using Deadline = std::optional<std::chrono::system_clock::time_point>;

  explicit Retries(Deadline deadline = {}) : deadline_(deadline) {}

  /// The operation made progress: later refusals count anew.
  void progressed();
  /// How long to wait before the call is repeated. Nothing: it must not be. Callers that were
  /// refused together come back one after the other.
  std::optional<std::chrono::milliseconds> pause(const grpc::Status& status);
  /// Sleeps for the pause. Returns false if there is none, or if a stop was requested meanwhile.
  bool wait(const grpc::Status& status, const std::stop_token& stop);

 private:
  const Deadline deadline_;
  int refused_ = 0;
  std::chrono::milliseconds waited_{0};
};

}  // namespace sightline::client::calls
