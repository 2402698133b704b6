// The formats of files of rays and hits, and the suffixes that name them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "client/result.h"

namespace sightline::client::cli::files {

enum class Format : std::uint8_t { kCsv, kNdjson, kNpy, kNpz, kPly };

/// The values of --out-format.
extern const std::map<std::string, Format> kFormats;

/// What the suffix of a path says, in either case; nothing for a path without a suffix. Errors:
/// kInvalidArgument, a suffix of no known format.
Result<std::optional<Format>> format_of(const std::string& path);

}  // namespace sightline::client::cli::files
