// Assimp's animations as plain data. Internal to the importer.
#pragma once

#include <assimp/scene.h>

#include <vector>

#include "client/importer/animation.h"
#include "client/importer/skin_from_assimp.h"

namespace sightline::client::importer {

/// `nodes` are Assimp's nodes by their numbers, `by_name` their numbers by name. Keys are
/// interpolated linearly, because Assimp does not report other modes; they may be in any order, and
/// not finite.
std::vector<Animation> animations_from_assimp(const aiScene& source,
                                              const std::vector<const aiNode*>& nodes,
                                              const NodesByName& by_name);

}  // namespace sightline::client::importer
