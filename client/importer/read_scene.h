// Reads a scene file in this process. A damaged file may make Assimp crash or run for hours: see
// assimp_import.h. Internal to the importer.
#pragma once

#include <string>

#include "client/importer/animation.h"
#include "client/importer/file_scene.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// Does what import_animated_scene does; messages do not have the file's name.
Result<AnimatedScene> read_scene(const std::string& name, const FileSource& files,
                                 const ImportOptions& options = {},
                                 const ImportProgress& progress = {});

}  // namespace sightline::client::importer
