// Assimp's scene as plain arrays, in the frame asked for. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include <string_view>

#include "client/importer/animation.h"
#include "client/importer/assimp_import.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// What import_unrebased makes of a scene that Assimp's importer of that name has read. Errors:
/// those of scene_from_assimp; a transform that is not finite once it is scaled.
Result<ImportedScene> convert_scene(const aiScene& source, std::string_view importer_name,
                                    const ImportOptions& options);

/// What import_animated_scene makes of it. Errors: as above, and those of animation_from_assimp.
Result<AnimatedScene> convert_animated_scene(const aiScene& source, std::string_view importer_name,
                                             const ImportOptions& options);

}  // namespace sightline::client::importer
