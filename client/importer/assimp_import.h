// Reads a scene file: glTF, GLB, OBJ, PLY, STL, DAE, IFC, AC, FBX. The file may come
// from a stranger: a child process reads it, which has limits on memory and time, no network, and
// no files but those in the folder of the scene file and below.
#pragma once

#include <filesystem>

#include "client/importer/animation.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// Whether this is a regular file that can be read. Errors: kInvalidArgument, with the system's
/// message, or that it is a directory, a pipe, a device or a socket; kResourceExhausted: this
/// machine has less memory than the file has bytes.
Status check_readable(const std::filesystem::path& file);

/// Cuts polygons into triangles and does nothing else to the file: no vertex is merged, no face
/// repaired, no transform applied. Vertices that lie far from their origin are moved near to it,
/// without moving a triangle (rebase.h). Faces keep their order: the n - 2 triangles of a polygon
/// are consecutive primitive ids. A node with several meshes keeps its name and gets a child for
/// each, NAME#0, NAME#1, ...; a mesh of several nodes stays one mesh. Textures are not read.
/// Errors: kInvalidArgument: file unreadable or incomplete, a transform that is not finite, an
/// index out of range, a child process that died of the file or reached a limit
/// (sandbox/sandbox.h); kUnimplemented: the system cannot confine the child. Forks; safe in a
/// process with threads, and from several at once. `progress` is called on this thread.
Result<ImportedScene> import_scene(const std::filesystem::path& file,
                                   const ImportOptions& options = {},
                                   const ImportProgress& progress = {});

/// Returns the same scene, bit for bit, with its animations. Errors: as above; an animation whose
/// keys are not finite or not in order of time; a bone that is no node of the file.
Result<AnimatedScene> import_animated_scene(const std::filesystem::path& file,
                                            const ImportOptions& options = {},
                                            const ImportProgress& progress = {});

}  // namespace sightline::client::importer
