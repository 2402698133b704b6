// Assimp's scene as a file scene. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include <string>
#include <string_view>
#include <vector>

#include "client/importer/file_scene.h"
#include "client/result.h"
#include "client/types.h"

namespace sightline::client::importer {

/// Takes a scene with a root node, read by Assimp's importer of this name and not processed.
/// Errors: kInvalidArgument: a mesh whose vertices have no positions; those of skin_from_assimp.h.
Result<FileScene> file_scene_from_assimp(const aiScene& source, std::string_view importer_name);

Transform transform_from_assimp(const aiMatrix4x4& matrix);

}  // namespace sightline::client::importer
