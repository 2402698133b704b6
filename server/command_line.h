// The flags of sightlined.
#pragma once

#include <spdlog/common.h>

#include <variant>

#include "server/config.h"

namespace sightline::server {

struct CommandLine {
  ServerConfig config;
  spdlog::level::level_enum log_level = spdlog::level::info;
};

inline constexpr int kUsageExit = 2;

/// Returns the flags, or an exit code: 0 after --help and --version, kUsageExit after a usage
/// error. The text is then already printed.
std::variant<CommandLine, int> parse_command_line(int argc, const char* const* argv);

}  // namespace sightline::server
