// Whether a row is what was written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sightline::server::store {

/// The first eight bytes of the SHA-256 of the bytes.
std::int64_t checksum_of(std::span<const std::byte> bytes);

}  // namespace sightline::server::store
