// Reads a scene file with Assimp: glTF, GLB, OBJ, PLY, STL, DAE, IFC, AC, FBX.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "client/importer/animation.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

struct ImportOptions {
  /// The scene is to have this axis up. Turned if the file says otherwise, else only recorded.
  std::optional<UpAxis> up_axis;
  /// The scene is to be in this unit, > 0. Scaled if the file names another, else only recorded.
  std::optional<double> meters_per_unit;
};

/// Whether the file is there to be read. Errors: kInvalidArgument, in the system's words.
Status check_readable(const std::filesystem::path& file);

/// Told how much of the file is read, from 0 to 1, on the importing thread.
using ImportProgress = std::function<void(double fraction)>;

/// Polygons are cut into triangles and nothing else is done to the file: no vertex is merged, no
/// face repaired, no transform applied. Vertices that lie far from their origin are brought near it
/// by `rebase`, which moves no triangle. A face's place in its Assimp mesh is its primitive id. A
/// node with several meshes keeps its name and gets a child for each, NAME#0, NAME#1, ...; a mesh
/// of several nodes stays one mesh. Textures are not read. Errors: kInvalidArgument, with Assimp's
/// own words where it has some: file unreadable or incomplete, a transform that is not finite, an
/// index out of range.
Result<ImportedScene> import_scene(const std::filesystem::path& file,
                                   const ImportOptions& options = {},
                                   const ImportProgress& progress = {});

/// The same scene, to the bit, and what of it moves. Errors: as above; an animation whose keys are
/// not finite or not in order of time; a bone that is no node of the file.
Result<AnimatedScene> import_animated_scene(const std::filesystem::path& file,
                                            const ImportOptions& options = {},
                                            const ImportProgress& progress = {});

/// The same scene without the rebasing.
Result<ImportedScene> import_unrebased(const std::filesystem::path& file,
                                       const ImportOptions& options = {},
                                       const ImportProgress& progress = {});

}  // namespace sightline::client::importer
