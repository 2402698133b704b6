// Assimp's scene as plain arrays. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include <string>
#include <string_view>
#include <vector>

#include "client/importer/imported_scene.h"
#include "client/result.h"
#include "client/types.h"

namespace sightline::client::importer {

/// Makes a node name fit for a message: `name` if it is UTF-8, else `name` read as Latin-1,
/// followed by `suffix`. A name that is too long is cut between characters, so that the result has
/// at most kMaxNodeName bytes.
std::string node_name(std::string_view name, std::string_view suffix = {});

struct ConvertedScene {
  ImportedScene scene;  ///< its frame is not known yet, and no vertex is rebased
  /// For each node, its source. Null for a child that was made for one of several meshes.
  std::vector<const aiNode*> sources;
};

/// Errors: kInvalidArgument: a transform that is not finite, an index out of range, a mesh whose
/// vertices have no positions.
Result<ConvertedScene> scene_from_assimp(const aiScene& source);

/// Errors: kInvalidArgument: not finite. `node` is the owner's name, for the message.
Result<Transform> transform_from_assimp(const aiMatrix4x4& matrix, const std::string& node);

}  // namespace sightline::client::importer
