// How a call ends: errors as gRPC status, quotes of what the client sent, and a log line.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <type_traits>

#include "proto/result.h"

namespace sightline::server::exec {

inline constexpr const char* kErrorDomain = "sightline";
/// A client that is refused because others have filled a queue is told to come back after this.
inline constexpr std::chrono::milliseconds kRetryDelay{1000};
/// Bytes of a message. Longer ones are cut: a status travels in HTTP/2 trailers, and peers limit
/// their size.
inline constexpr std::size_t kMaxStatusMessage = 1024;

/// An error with the code kInvalidArgument.
Error invalid_argument(std::string message, std::string reason);

/// The Status that work() returns, kResourceExhausted for std::bad_alloc, or kInternal for any
/// other exception. Tasks and reactors use it because no exception may leave them.
template <class Work>
Status to_status(Work&& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{Code::kResourceExhausted, "the server has no memory left for this",
                 "OUT_OF_MEMORY"};
  } catch (const std::exception& thrown) {
    return Error{Code::kInternal, thrown.what(), "UNEXPECTED"};
  }
}

/// The error's reason, for programs; the name of its code if it has none.
std::string reason_of(const Error& error);

/// The status with the error's code and message, and with a google.rpc.Status in its details that
/// has one google.rpc.ErrorInfo: reason_of() in the domain "sightline". If a queue is full, a
/// quota used up or something unavailable, also a google.rpc.RetryInfo with kRetryDelay.
grpc::Status to_grpc(const Error& error);

/// The error that to_grpc() wrote, at another server too; kInternal for a code that it never
/// writes.
Error error_of(const grpc::Status& status);

/// The reason that to_grpc() wrote; empty if the status has none.
std::string reason_of(const grpc::Status& status);

/// Whether the status tells its client when to come back.
bool asks_to_retry(const grpc::Status& status);

/// OK, or the error.
grpc::Status to_grpc(const Status& status);

inline constexpr std::size_t kMaxQuoted = 96;  ///< Bytes of a quoted text that are shown.

/// Quotes text of a client for a message or a log line: printable ASCII only (anything else is
/// shown as '?', a quote or backslash is escaped), cut after kMaxQuoted bytes; the full length is
/// then appended.
std::string quote(std::string_view text);

/// The metadata by which a client may name its request, for log lines.
inline constexpr const char* kRequestId = "x-request-id";

/// What the client says of a call, for its log lines: " request_id=" and the quoted name, then
/// " trace_id=" and the id of its one valid traceparent. Each is left out where it is not given.
std::string call_ids_of(const grpc::ServerContextBase& context);

/// Starts when a call arrives; log_rpc() writes the time since.
using LogClock = std::chrono::steady_clock;

/// Whether log_rpc() writes anything.
bool logs_rpcs();

/// Logs the end of a call in one line, at level debug: event=rpc method=... code=... us=...
/// [request_id=...] [trace_id=...], then `more` ("key=value ..." or nothing).
void log_rpc(std::string_view method, const grpc::ServerContextBase& context,
             const grpc::Status& status, LogClock::time_point begun, std::string_view more = {});

/// Does the same; more() is only called if the line is written.
template <class More>
  requires std::is_invocable_r_v<std::string, More>
void log_rpc(std::string_view method, const grpc::ServerContextBase& context,
             const grpc::Status& status, LogClock::time_point begun, const More& more) {
  if (logs_rpcs()) log_rpc(method, context, status, begun, std::string_view(more()));
}

}  // namespace sightline::server::exec
