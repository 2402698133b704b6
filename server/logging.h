// The server's log: lines on stderr, written by a thread of their own.
#pragma once

#include <spdlog/common.h>

namespace sightline::server {

/// Lines that wait to be written. The oldest are dropped while stderr is not read; the first line
/// after that says how many.
inline constexpr std::size_t kLogQueue = 4096;

/// Makes spdlog's default logger. Logging never blocks. Call it once, after signals are blocked,
/// as it starts a thread. gRPC's messages are logged too.
void start_logging(spdlog::level::level_enum level);

}  // namespace sightline::server
