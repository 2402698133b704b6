// Numbers as Collada files have them. Internal to the importer.
#pragma once

#include <cstddef>
#include <string_view>
#include <utility>

#include "client/result.h"

namespace sightline::client::importer {

/// The transforms that a node may have, with how many numbers each needs.
inline constexpr std::pair<std::string_view, std::size_t> kColladaTransforms[] = {
    {"matrix", 16}, {"translate", 3}, {"rotate", 4}, {"scale", 3}, {"lookat", 9}, {"skew", 7}};

/// The next word of the text, which is removed from it. Empty: there is none.
std::string_view take_collada_word(std::string_view& text);

/// Programs of some countries write decimal commas, and Assimp takes them for points. Errors:
/// kInvalidArgument: the word is no number, or one that Assimp takes for another.
Result<double> collada_number(std::string_view word);

}  // namespace sightline::client::importer
