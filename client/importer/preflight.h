// Checks a file for damage that Assimp does not survive, before Assimp reads it. Internal to the
// importer.
#pragma once

#include <string_view>

#include "client/result.h"

namespace sightline::client::importer {

/// Refuses files on which Assimp 5.2 hangs: a PLY file whose header has no end or announces more
/// than the file can hold. Errors: kInvalidArgument, for these. All other files are left to Assimp.
Status preflight(std::string_view bytes);

}  // namespace sightline::client::importer
