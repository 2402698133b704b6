// Uploads a scene of the bench to a server.
#pragma once

#include "client/client.h"
#include "proto/result.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

inline constexpr const char* kRemoteScene = "projects/bench/scenes/remote";

/// An error of the client as one of the bench.
Error error_of(const client::Error& error);

/// Uploads the scene as kRemoteScene, with the node ids of node_id(), and builds all its trees.
Status upload(const client::Client& client, const SceneSource& scene);

}  // namespace sightline::bench
