// The animations of a glTF file. Internal to the importer.
#pragma once

#include "client/importer/file_scene.h"
#include "client/importer/gltf/accessors.h"
#include "client/importer/gltf/document.h"
#include "client/importer/gltf/meshes.h"
#include "client/importer/gltf/nodes.h"

namespace sightline::client::importer::gltf {

/// Adds to the animations and warnings of `scene`, whose nodes are read. What is animated outside
/// the scene is ignored, and what is no transform and no weights of shapes is warned about.
/// `nodes`: those of the scene. Refuses samplers whose numbers of keys and values do not fit.
void read_animations(const Document& document, Accessors& accessors, const Meshes& meshes,
                     const Nodes& nodes, FileScene& scene);

}  // namespace sightline::client::importer::gltf
