// What can be told of an imported scene before a byte of it is sent.
#pragma once

#include "client/importer/imported_scene.h"
#include "client/result.h"
#include "client/scene_info.h"

namespace sightline::client::calls {

/// Transforms are refused over this: no ray could be carried through them with any precision left.
inline constexpr double kMaxCondition = 1e12;

/// Whether the server will take the scene. Errors, naming the node or mesh, the value and the
/// limit: kInvalidArgument (singular or nearly singular transform, hierarchy too deep),
/// kResourceExhausted (mesh too big).
Status check_scene(const importer::ImportedScene& scene, const ServerInfo& limits);

}  // namespace sightline::client::calls
