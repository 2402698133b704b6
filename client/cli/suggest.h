// What a misspelt word may have meant.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace sightline::client::cli {

/// The number of letters to insert, drop, replace or swap with their neighbour, to make one word of
/// the other.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word that is nearest to `word`; empty if none is near.
std::string nearest(std::string_view word, std::span<const std::string> words);

}  // namespace sightline::client::cli
