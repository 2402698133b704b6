// Checks a file for damage that Assimp does not survive, before Assimp reads it. Internal to the
// importer.
#pragma once

#include <string_view>

#include "client/result.h"

namespace sightline::client::importer {

inline constexpr std::size_t kDeepestJson = 256;   ///< nesting depth of brackets
inline constexpr std::size_t kDeepestNode = 4096;  ///< Assimp follows children by recursion
/// A file may always have as many as it lists.
inline constexpr std::uint64_t kMostNodes = 1U << 20U;

/// Checks how many and how deep the nodes of a glTF file are. `json` is a .gltf file, or the first
/// chunk of a .glb file. A node with several parents counts once for each, so a few lines may stand
/// for more nodes than fit in memory. Text that is no JSON, or that refers to itself, is left to
/// Assimp, which reports it. Errors: kInvalidArgument, over these limits.
Status check_gltf_nodes(std::string_view json);

/// Refuses files on which Assimp 5.2 hangs or crashes: a GLB file whose chunks are longer than the
/// file, and a glTF or GLB file with too many or too deep nodes (check_gltf_nodes). Errors: kInvalidArgument,
/// for these. All other files are left to Assimp. `name` is that of the file, `bytes` its contents.
Status preflight(std::string_view name, std::string_view bytes);

}  // namespace sightline::client::importer
