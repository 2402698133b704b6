// What an imported scene tells of its own defects. Internal to the importer.
#pragma once

#include <vector>

#include "client/importer/file_scene.h"
#include "client/importer/imported_scene.h"

namespace sightline::client::importer {

/// Adds warnings to the scene: parts that are said to be solids and are not closed, nodes with a
/// mesh whose transforms are flat; and a note of edges that only one triangle has. A part is what a
/// node of the file has, with all its meshes. `nodes` are those of the file, `is_solid` has a
/// flag for each mesh.
void self_check(const std::vector<FileNode>& nodes, const std::vector<bool>& is_solid,
                ImportedScene& scene);

}  // namespace sightline::client::importer
