// Our errors as gRPC sees them.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "accel/result.h"

namespace sightline::server::exec {

inline constexpr const char* kErrorDomain = "sightline";
/// A status travels in HTTP/2 trailers, which peers bound (8 KiB by default): longer messages are
/// cut.
inline constexpr std::size_t kMaxStatusMessage = 1024;

/// For programs: the error's reason, or its code's name if it has none.
std::string reason_of(const Error& error);

/// The status with the error's code and message, and with a google.rpc.Status in its details that
/// carries one google.rpc.ErrorInfo: reason_of() in the domain "sightline".
grpc::Status to_grpc(const Error& error);

/// OK, or the error.
grpc::Status to_grpc(const Status& status);

}  // namespace sightline::server::exec
