// Reads OBJ files (Wavefront): vertices, polygons, lines and points. Internal to the importer.
#pragma once

#include "client/importer/file_scene.h"
#include "client/result.h"

namespace sightline::client::importer::formats {

/// Each `o`, and each `g` of another name, is a node below a root that has the file's name; a
/// material that changes within it begins another mesh. A mesh has the vertices that its faces
/// name, in the order of the file. Positions are the nearest doubles. Materials, normals and
/// texture coordinates are not read; weights of vertices, curves and surfaces are not read with a
/// warning. Errors: kInvalidArgument, with the line: a word that is no number or no corner, a
/// vertex that does not exist, a last line that is cut off.
Result<FileScene> read_obj(const SceneFile& file);

}  // namespace sightline::client::importer::formats
