// Reads glTF 2.0, as JSON or as GLB. Internal to the importer.
#pragma once

#include "client/importer/file_scene.h"
#include "client/result.h"

namespace sightline::client::importer::gltf {

/// Reads the scene that the file shows, with meshes, skins, shapes and animations, but not its
/// materials and textures. A mesh without a name is meshes[N], and a node nodes[N], by its number
/// in the file; several primitives of a mesh are NAME-0, NAME-1 and so on. Errors:
/// kInvalidArgument: the file is damaged, is no glTF 2.0, or requires an extension that is not
/// read.
Result<FileScene> read_gltf(const SceneFile& file);

}  // namespace sightline::client::importer::gltf
