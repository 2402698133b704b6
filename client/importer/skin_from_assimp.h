// Assimp's bones and morph targets of one mesh. Internal to the importer.
#pragma once

#include <assimp/mesh.h>

#include <cstdint>
#include <string>
#include <unordered_map>

#include "client/importer/animation.h"
#include "client/result.h"

namespace sightline::client::importer {

/// The first node of each name. Assimp means that one.
using NodesByName = std::unordered_map<std::string, std::uint32_t>;

/// Scales the weights of each vertex so that they add up to 1. Errors: kInvalidArgument: a bone
/// that is no node, a weight for a vertex that does not exist, or one that is negative or not
/// finite.
Result<Skin> skin_from_assimp(const aiMesh& mesh, const NodesByName& nodes);

/// Errors: kInvalidArgument: a shape with a different number of vertices than the mesh.
Result<Shapes> shapes_from_assimp(const aiMesh& mesh);

}  // namespace sightline::client::importer
