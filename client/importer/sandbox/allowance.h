// How much the reader of a scene file may use.
#pragma once

#include <cstdint>
#include <limits>

namespace sightline::client::importer::sandbox {

/// A fixed amount, and an amount for each stored byte of the files that it opened.
struct Allowance {
  std::uint64_t fixed = 0;
  std::uint64_t per_byte = 0;

  std::uint64_t of(std::uint64_t bytes) const {
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max() / 4;
    return bytes > (kMost - fixed) / per_byte ? kMost : fixed + per_byte * bytes;
  }
};

}  // namespace sightline::client::importer::sandbox
