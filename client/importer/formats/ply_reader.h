// Reads PLY files (Stanford): one mesh of faces and triangle strips, or a cloud of points. Internal
// to the importer.
#pragma once

#include "client/importer/file_scene.h"
#include "client/result.h"

namespace sightline::client::importer::formats {

/// Text, or binary in either order of bytes. Vertices may have numbers of any type as x, y, z;
/// faces are the lists vertex_index or vertex_indices of the elements face and tristrips, in which
/// -1 ends a strip. Other properties are skipped, other elements, too, with a warning. Errors:
/// kInvalidArgument: those of read_ply_header; vertices without x, y or z, faces without a list, a
/// vertex that does not exist, a file that ends too early, a word that is no number.
Result<FileScene> read_ply(const SceneFile& file);

}  // namespace sightline::client::importer::formats
