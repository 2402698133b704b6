// What a Collada file says of its own numbers, and Assimp does not check. Internal to the importer.
#pragma once

#include <string_view>

#include "client/result.h"

namespace sightline::client::importer {

/// Whether arrays have the numbers that accessors read, positions have one X, Y and Z, polygons
/// name no vertex below 0, vertices have one position, and transforms have as many numbers as they
/// need, which Assimp takes as they are meant. Otherwise Assimp reads past the end of arrays, or
/// takes other numbers. Arrays of looks, such as normals, are not checked. `text`: the contents of
/// the file, not packed. Errors: kInvalidArgument, with the element and what is wrong with it.
Status check_collada(std::string_view text);

}  // namespace sightline::client::importer
