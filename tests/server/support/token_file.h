// Files of tokens.
#pragma once

#include <string>
#include <string_view>

namespace sightline::tests {

/// SHA-256 in hex digits.
std::string hash_of(std::string_view token);

/// One [[token]]. `prefixes`: the elements of the list, with their quotes.
std::string token_row(std::string_view name, std::string_view token, std::string_view role,
                      std::string_view prefixes);

}  // namespace sightline::tests
