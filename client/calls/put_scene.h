// A scene with all its nodes in one step. Internal to the library.
#pragma once

#include <span>
#include <string>

#include "client/result.h"
#include "client/scene_info.h"
#include "client/update.h"

namespace sightline::client::calls {

struct Connection;

/// Does what Client::put_scene does.
Result<SceneInfo> put_scene(const Connection& connection, const std::string& scene,
                            std::span<const PutNode> nodes, const PutSceneOptions& options);

}  // namespace sightline::client::calls
