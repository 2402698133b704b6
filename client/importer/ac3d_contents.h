// What an AC3D file says of the places of its objects, and Assimp takes otherwise. Internal to the
// importer.
#pragma once

#include <string_view>

#include "client/importer/file_scene.h"

namespace sightline::client::importer {

/// Warns of objects that Assimp puts elsewhere: those that are turned, as it turns them the other
/// way, and those below an object with surfaces that is moved, as it moves the surfaces alone.
void check_ac3d(std::string_view text, FileScene& scene);

}  // namespace sightline::client::importer
