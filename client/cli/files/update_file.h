// Files of updates: a JSON object a line.
#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "client/result.h"
#include "client/update.h"

namespace sightline::client::cli::files {

/// Reads all updates of a file; "-" is standard input. Errors: those of Input; a local error,
/// naming the line, if one is no update; kCancelled.
Result<std::vector<Update>> read_updates(const std::string& file, const std::stop_token& stop);

}  // namespace sightline::client::cli::files
