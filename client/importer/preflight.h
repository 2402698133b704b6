// Checks a file for damage that Assimp does not survive, before Assimp reads it. Internal to the
// importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "client/result.h"

namespace sightline::client::importer {

inline constexpr std::size_t kDeepestJson = 256;        ///< Brackets in brackets.
inline constexpr std::size_t kDeepestNode = 4096;       ///< Assimp follows children by recursion.
inline constexpr std::uint64_t kMostNodes = 1U << 20U;  ///< But always as many as are listed.

/// `json` is a .gltf file, or the first chunk of a .glb file. A node that is the child of several
/// stands for as many nodes, and so a few lines may stand for more than there is memory for. What
/// is no JSON, or refers to itself, is left to Assimp, which says so. Errors: kInvalidArgument,
/// over these limits.
Status check_gltf_nodes(std::string_view json);

/// Assimp 5.2 never comes back, or takes the program with it, from a PLY file whose header has no
/// end or announces more than the file can hold, a GLB file whose chunks are longer than it, and a
/// glTF or GLB file with too many or too deep nodes (check_gltf_nodes). Errors: kInvalidArgument,
/// for these. Any other file is left to Assimp.
Status preflight(const std::filesystem::path& file);

}  // namespace sightline::client::importer
