// Numbers as people read them.
#pragma once

#include <cstdint>
#include <string>

namespace sightline::client::cli {

/// 1234567 as "1,234,567".
std::string grouped(std::uint64_t number);

/// "1,234 of 75,730 (1.6 %)"; without a share of nothing.
std::string part_of(std::uint64_t part, std::uint64_t whole);

/// "12.3 MB", in steps of 1,000; below 1,000 "321 B".
std::string bytes_text(std::uint64_t bytes);

}  // namespace sightline::client::cli
