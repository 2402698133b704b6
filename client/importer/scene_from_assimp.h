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

/// `name` if it is UTF-8, else read as Latin-1; then `suffix`. Cut between characters, in the name,
/// to stay within kMaxNodeName bytes.
std::string node_name(std::string_view name, std::string_view suffix = {});

struct ConvertedScene {
  ImportedScene scene;  ///< Its frame not known yet, no vertex rebased.
  /// For every node what it was made of; null for a child that stands for one of several meshes.
  std::vector<const aiNode*> sources;
};

/// Errors: kInvalidArgument: a transform that is not finite, an index out of range, a mesh whose
/// vertices have no positions.
Result<ConvertedScene> scene_from_assimp(const aiScene& source);

/// Errors: kInvalidArgument: not finite; `node` is who it belongs to.
Result<Transform> transform_from_assimp(const aiMatrix4x4& matrix, const std::string& node);

}  // namespace sightline::client::importer
