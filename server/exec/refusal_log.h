// A line of the log for calls that are refused: those without the right to call, and those beyond a
// limit.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "server/exec/token_bucket.h"

namespace sightline::server::exec {

/// Bounds the lines, as a client may be refused thousands of times a second. Threads: any, for
/// every member.
class RefusalLog {
 public:
  using Clock = TokenBucket::Clock;
  static constexpr std::uint64_t kLinesPerSecond = 10;

  explicit RefusalLog(Clock::time_point now) : lines_(kLinesPerSecond, now) {}

  /// Counts a refusal. Returns how many there were since the last line, this one included; nothing
  /// where it gets no line.
  std::optional<std::uint64_t> count(Clock::time_point now);

 private:
  std::mutex mutex_;
  TokenBucket lines_;           // protected by mutex_
  std::uint64_t unlogged_ = 0;  // protected by mutex_
};

/// Interceptors for grpc::ServerBuilder that log refusals at level info: event=refused method=...
/// code=... reason=... peer=... since_last=..., then call_ids_of(). `log` outlives the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> log_refusals(
    RefusalLog& log);

}  // namespace sightline::server::exec
