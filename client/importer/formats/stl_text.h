// Reads STL files in text. Internal to the importer.
#pragma once

#include "client/importer/file_scene.h"
#include "client/result.h"

namespace sightline::client::importer::formats {

/// Reads a file that is text, as read_stl does.
Result<FileScene> read_stl_text(const SceneFile& file);

/// Adds the vertex, and a corner with its number.
void add_stl_vertex(FileMesh& mesh, const Point& vertex);

}  // namespace sightline::client::importer::formats
