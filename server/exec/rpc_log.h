// One log line per call, at level debug.
#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <string_view>

namespace sightline::server::exec {

using LogClock = std::chrono::steady_clock;

/// event=rpc method=... code=... us=..., then `more` ("key=value ..." or nothing).
void log_rpc(std::string_view method, const grpc::Status& status, LogClock::time_point begun,
             std::string_view more = {});

}  // namespace sightline::server::exec
