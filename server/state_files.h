// The files a server keeps beside its memory.
#pragma once

#include <filesystem>

#include "accel/result.h"

namespace sightline::server {

/// Creates the directory and those above it. An empty path: nothing to do.
/// Errors: kFailedPrecondition, if it cannot be made or written into.
Status make_data_dir(const std::filesystem::path& directory);

/// Writes the port and a newline, whole or not at all. An empty path: nothing to do.
/// Errors: kFailedPrecondition.
Status write_port_file(const std::filesystem::path& file, int port);

}  // namespace sightline::server
