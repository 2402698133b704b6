// The table of scenes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// Errors of all: as Database.

/// Errors: also kAlreadyExists.
Result<SceneId> insert_scene(Database& database, const SceneInfo& info);
/// Errors: also kNotFound.
Result<SceneRecord> find_scene(Database& database, SceneId scene);
/// Nothing: there is no scene of this name.
Result<std::optional<SceneRecord>> find_scene_named(Database& database, const std::string& name);
/// By name.
Result<std::vector<SceneRecord>> all_scenes(Database& database);
/// By id.
Result<std::vector<SceneHead>> all_heads(Database& database);
/// Its rows become garbage. Errors: also kNotFound.
Status mark_removed(Database& database, SceneId scene);
/// The error for a name that another scene has.
Error scene_exists(const std::string& name);
/// The error for a scene that is not there.
Error no_scene(SceneId scene);

}  // namespace sightline::server::store
