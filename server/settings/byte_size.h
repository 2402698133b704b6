// Sizes in bytes, as people write them: 4G, 512MiB, 64k.
#pragma once

#include <cstdint>
#include <string_view>

#include "proto/result.h"

namespace sightline::server::settings {

/// Parses a whole number of bytes, with or without a unit behind it and without a blank between.
/// K, M, G and T are powers of 1024 and may be small letters; KiB, MiB, GiB and TiB are the same.
/// kB (or KB), MB, GB and TB are powers of 1000, and B is one byte.
/// Errors: kInvalidArgument, with the text and what is allowed: no such number, or one that is not
/// from `least` to 2^64 - 1.
Result<std::uint64_t> parse_byte_size(std::string_view text, std::uint64_t least);

}  // namespace sightline::server::settings
