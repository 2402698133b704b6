// Damage to a file that Assimp does not survive, looked for before it reads. Internal to the
// importer.
#pragma once

#include <filesystem>

#include "client/result.h"

namespace sightline::client::importer {

/// Assimp 5.2 never comes back, or takes the program with it, from a PLY file whose header has no
/// end or announces more than the file can hold, a GLB file whose chunks are longer than it, and a
/// glTF or GLB file with too many or too deep nodes (check_gltf_nodes). Errors: kInvalidArgument,
/// for these. Any other file is left to Assimp.
Status check_damage(const std::filesystem::path& file);

}  // namespace sightline::client::importer
