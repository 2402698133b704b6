// Assimp's animations, bones and morph targets as plain data. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include "client/importer/animation.h"
#include "client/importer/scene_from_assimp.h"
#include "client/result.h"

namespace sightline::client::importer {

/// Takes the converted scene over; what turns or rebases it later is to be told to its rig. Keys
/// are mixed linearly, as Assimp does not say where a file wants otherwise. Errors:
/// kInvalidArgument: keys that are not finite or not in order of time, an animation that never
/// ends, a bone that is no node, a weight of a vertex that there is not.
Result<AnimatedScene> animation_from_assimp(const aiScene& source, ConvertedScene converted);

}  // namespace sightline::client::importer
