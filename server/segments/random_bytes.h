// Names and keys that cannot be guessed.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace sightline::server::segments {

/// Fills up to 256 bytes at random, from the system. Throws std::system_error if it gives none.
void fill_at_random(std::span<std::uint8_t> bytes);

/// 128 random bits as 32 hex digits.
std::string random_name();

}  // namespace sightline::server::segments
