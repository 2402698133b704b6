// The content of a small file that an operator names.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "proto/result.h"

namespace sightline::server::security {

/// Errors: kFailedPrecondition, naming the file, if it cannot be read or has more than `limit`
/// bytes.
Result<std::string> read_file(const std::filesystem::path& file, std::size_t limit);

}  // namespace sightline::server::security
