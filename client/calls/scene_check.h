// Checks an imported scene before anything is sent.
#pragma once

#include "client/importer/imported_scene.h"
#include "client/result.h"
#include "client/scene_info.h"

namespace sightline::client::calls {

/// Whether the server will accept the scene. Errors, naming the node or mesh, the value and the
/// limit: kInvalidArgument (transform that is not finite, hierarchy too deep), kResourceExhausted
/// (mesh too big).
Status check_scene(const importer::ImportedScene& scene, const ServerInfo& limits);

}  // namespace sightline::client::calls
