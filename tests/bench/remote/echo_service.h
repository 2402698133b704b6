// A service that answers casts with the bytes that it got: the least that a call can cost.
#pragma once

#include <string>

#include "proto/result.h"

namespace sightline::bench {

/// The argument with which sightline-bench becomes this service.
inline constexpr const char* kEchoVerb = "echo-service";

/// Serves CastRays and StreamCastRays on a free port of the loopback interface, which it prints as
/// " port=N", and at the Unix socket of this path (empty: none), until the process is ended. The
/// one column of a reply is the origins of its rays.
Status run_echo_service(const std::string& socket);

}  // namespace sightline::bench
