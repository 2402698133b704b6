// What Assimp makes of the products of an IFC file, held against the file. Internal to the
// importer.
#pragma once

#include "client/importer/file_scene.h"
#include "client/importer/ifc_statements.h"

namespace sightline::client::importer {

/// Assimp's nodes of IFC products are named TYPE_NAME_GLOBALID. Returns the GlobalId, or nothing.
std::string_view global_id_of(const FileNode& node);

/// Warns of products that have fewer meshes in `scene`, which Assimp has read, than their body has
/// items; of products for which Assimp has taken another representation than the body; and of
/// shapes that Assimp changes. A note tells of spaces, which Assimp leaves out.
void check_products(const Statements& statements, FileScene& scene);

}  // namespace sightline::client::importer
