// The table of scenes.
#pragma once

#include <vector>

#include "accel/result.h"
#include "server/store/database.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// Errors of all: as Database.

/// Errors: also kAlreadyExists.
Result<SceneId> insert_scene(Database& database, const SceneInfo& info);
/// Errors: also kNotFound.
Result<SceneRecord> find_scene(Database& database, SceneId scene);
/// By name.
Result<std::vector<SceneRecord>> all_scenes(Database& database);
/// Its rows become garbage. Errors: also kNotFound.
Status mark_removed(Database& database, SceneId scene);
/// The error for a scene that is not there.
Error no_scene(SceneId scene);

}  // namespace sightline::server::store
