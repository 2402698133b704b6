// Assimp's bones and morph targets of one mesh. Internal to the importer.
#pragma once

#include <assimp/mesh.h>

#include <cstdint>
#include <string>
#include <unordered_map>

#include "client/importer/animation.h"
#include "client/result.h"

namespace sightline::client::importer {

/// The first node of each name, which is the one that Assimp means by it.
using NodesByName = std::unordered_map<std::string, std::uint32_t>;

/// Weights of a vertex are made to add up to 1. Errors: kInvalidArgument: a bone that is no node, a
/// weight of a vertex that there is not, or that is negative or not finite.
Result<Skin> skin_from_assimp(const aiMesh& mesh, const NodesByName& nodes);

/// Errors: kInvalidArgument: a shape that has not as many vertices as the mesh.
Result<Shapes> shapes_from_assimp(const aiMesh& mesh);

}  // namespace sightline::client::importer
