// Exceptions and errors of the project as Status and as gRPC status.
#pragma once

#include <grpcpp/support/status.h>

#include <exception>
#include <new>
#include <string>

#include "accel/result.h"

namespace sightline::server::exec {

inline constexpr const char* kErrorDomain = "sightline";
/// Bytes. Longer messages are cut: a status travels in HTTP/2 trailers, and peers limit their size.
inline constexpr std::size_t kMaxStatusMessage = 1024;

/// The Status that work() returns; kResourceExhausted for std::bad_alloc; kInternal for any other
/// exception. Tasks and reactors use it because no exception may leave them.
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

/// For programs: the error's reason, or its code's name if it has none.
std::string reason_of(const Error& error);

/// The status with the error's code and message, and with a google.rpc.Status in its details that
/// carries one google.rpc.ErrorInfo: reason_of() in the domain "sightline".
grpc::Status to_grpc(const Error& error);

/// OK, or the error.
grpc::Status to_grpc(const Status& status);

}  // namespace sightline::server::exec
