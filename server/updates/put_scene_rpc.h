// SceneService.PutScene: a scene with all its nodes in one step.
#pragma once

#include <chrono>
#include <cstddef>

#include "server/scenes/services.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::server::updates {

/// Open PutScene calls on the whole server.
inline constexpr std::size_t kMaxScenePuts = 64;
/// Longest time between two messages of such a call.
inline constexpr std::chrono::seconds kPutTimeout{20};

/// The reactor of a new call; it deletes itself. The arguments outlive the call.
grpc::ServerReadReactor<v1::PutSceneRequest>* start_put_scene(const scenes::Services& services,
                                                              grpc::CallbackServerContext& context,
                                                              v1::PutSceneResponse& reply);

}  // namespace sightline::server::updates
