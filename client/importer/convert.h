// Assimp's scene as plain arrays, in the requested frame. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include <string_view>

#include "client/importer/animation.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// The conversion step of import_unrebased, for a scene read by Assimp's importer of this name.
/// Errors: those of scene_from_assimp; a transform that is not finite after scaling.
Result<ImportedScene> convert_scene(const aiScene& source, std::string_view importer_name,
                                    const ImportOptions& options);

/// The conversion step of import_animated_scene. Errors: as above, and those of
/// animation_from_assimp.
Result<AnimatedScene> convert_animated_scene(const aiScene& source, std::string_view importer_name,
                                             const ImportOptions& options);

}  // namespace sightline::client::importer
