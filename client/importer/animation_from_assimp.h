// Assimp's animations, bones and morph targets as plain data. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include "client/importer/animation.h"
#include "client/importer/scene_from_assimp.h"
#include "client/result.h"

namespace sightline::client::importer {

/// Takes the converted scene. A later turn or rebasing of the scene must be recorded in the rig.
/// Keys are interpolated linearly, because Assimp does not report other modes. Errors:
/// kInvalidArgument: keys that are not finite or not in order of time, an animation without an end,
/// a bone that is no node, a weight for a vertex that does not exist.
Result<AnimatedScene> animation_from_assimp(const aiScene& source, ConvertedScene converted);

}  // namespace sightline::client::importer
