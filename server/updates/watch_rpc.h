// SceneService.WatchScene: every revision of a scene as it is made.
#pragma once

#include <chrono>
#include <cstddef>

#include "server/scenes/services.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::server::updates {

/// Open WatchScene calls on the whole server.
inline constexpr std::size_t kMaxWatches = 256;
/// Longest time between two messages of a watch.
inline constexpr std::chrono::seconds kWatchProgress{5};

/// The reactor of a new call; it deletes itself. The arguments outlive the call.
grpc::ServerWriteReactor<v1::WatchSceneResponse>* start_watch(const scenes::Services& services,
                                                              grpc::CallbackServerContext& context,
                                                              const v1::WatchSceneRequest& request);

}  // namespace sightline::server::updates
