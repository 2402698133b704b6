// Reads a scene file with Assimp in this process. Assimp may crash or run for hours on a damaged
// file: see assimp_import.h. Internal to the importer.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/importer/animation.h"
#include "client/importer/assimp_file.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// As import_unrebased, but messages do not have the file's name.
Result<ImportedScene> read_scene(const std::string& name, const FileSource& files,
                                 const ImportOptions& options = {},
                                 const ImportProgress& progress = {});

/// As import_animated_scene.
Result<AnimatedScene> read_animated_scene(const std::string& name, const FileSource& files,
                                          const ImportOptions& options = {},
                                          const ImportProgress& progress = {});

/// The conversion step of read_scene, for a scene read by Assimp's importer of this name. Errors:
/// those of scene_from_assimp; a transform that is not finite after scaling.
Result<ImportedScene> convert_scene(const aiScene& source, std::string_view importer_name,
                                    const ImportOptions& options);

/// The conversion step of read_animated_scene. Errors: as above, and those of
/// animation_from_assimp.
Result<AnimatedScene> convert_animated_scene(const aiScene& source, std::string_view importer_name,
                                             const ImportOptions& options);

/// What was noticed while the scene was read.
inline std::vector<std::string>& warnings_of(ImportedScene& scene) { return scene.warnings; }
inline std::vector<std::string>& warnings_of(AnimatedScene& scene) { return scene.scene.warnings; }

}  // namespace sightline::client::importer
