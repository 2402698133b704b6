// Reads a scene file with Assimp: glTF, GLB, OBJ, PLY, STL, DAE, IFC, AC, FBX.
#pragma once

#include <filesystem>
#include <string_view>

#include "client/importer/animation.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

struct aiScene;

namespace sightline::client::importer {

/// Whether the file exists and can be read. Errors: kInvalidArgument, with the system's message.
Status check_readable(const std::filesystem::path& file);

/// Cuts polygons into triangles and does nothing else to the file: no vertex is merged, no face
/// repaired, no transform applied. `rebase` moves vertices that lie far from their origin near to
/// it, without moving a triangle. The index of a face in its Assimp mesh is its primitive id. A
/// node with several meshes keeps its name and gets a child for each, NAME#0, NAME#1, ...; a mesh
/// of several nodes stays one mesh. Textures are not read. Errors: kInvalidArgument, with Assimp's
/// message if it has one: file unreadable or incomplete, a transform that is not finite, an index
/// out of range.
Result<ImportedScene> import_scene(const std::filesystem::path& file,
                                   const ImportOptions& options = {},
                                   const ImportProgress& progress = {});

/// Returns the same scene, bit for bit, with its animations. Errors: as above; an animation whose
/// keys are not finite or not in order of time; a bone that is no node of the file.
Result<AnimatedScene> import_animated_scene(const std::filesystem::path& file,
                                            const ImportOptions& options = {},
                                            const ImportProgress& progress = {});

/// Returns the same scene without rebasing.
Result<ImportedScene> import_unrebased(const std::filesystem::path& file,
                                       const ImportOptions& options = {},
                                       const ImportProgress& progress = {});

/// The conversion step of import_unrebased, for a scene read by Assimp's importer of this name.
/// Errors: those of scene_from_assimp; a transform that is not finite after scaling.
Result<ImportedScene> convert_scene(const aiScene& source, std::string_view importer_name,
                                    const ImportOptions& options);

/// The conversion step of import_animated_scene. Errors: as above, and those of
/// animation_from_assimp.
Result<AnimatedScene> convert_animated_scene(const aiScene& source, std::string_view importer_name,
                                             const ImportOptions& options);

}  // namespace sightline::client::importer
