// Files that a server writes.
#pragma once

#include <filesystem>

#include "proto/result.h"

namespace sightline::server {

/// Creates the directory and its parents. An empty path: nothing to do.
/// Errors: kFailedPrecondition, if it cannot be created or written to.
Status make_data_dir(const std::filesystem::path& directory);

/// Writes the port and a newline atomically. An empty path: nothing to do.
/// Errors: kFailedPrecondition.
Status write_port_file(const std::filesystem::path& file, int port);

}  // namespace sightline::server
