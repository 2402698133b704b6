// SceneService.WatchScene: every revision of a scene as it is made.
#pragma once

#include <chrono>

#include "server/updates/update_services.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::server::updates {

/// Between two messages of a watch, at most.
inline constexpr std::chrono::seconds kWatchProgress{5};

/// The reactor of a new call; it frees itself. The arguments outlive the call.
grpc::ServerWriteReactor<v1::WatchSceneResponse>* start_watch(const UpdateServices& services,
                                                              const v1::WatchSceneRequest& request);

}  // namespace sightline::server::updates
