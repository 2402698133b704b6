// Reads STL files, in text or in binary. Internal to the importer.
#pragma once

#include "client/importer/file_scene.h"
#include "client/result.h"

namespace sightline::client::importer::formats {

/// Each solid of a text is a node with a mesh of its name; keywords may be in any case. A binary
/// file is a mesh without a name; if its size and the number of facets in its header differ, a
/// warning says which of the two counts. Normals, colors and attributes are not read. Each facet
/// has vertices of its own. Errors: kInvalidArgument: neither a text nor a header; a binary file
/// that is cut off; with the line: a facet without three vertices, a word that is no number.
Result<FileScene> read_stl(const SceneFile& file);

}  // namespace sightline::client::importer::formats
