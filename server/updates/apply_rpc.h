// SceneService.ApplyUpdates: applies one batch on the scene's write queue.
#pragma once

#include <grpcpp/support/server_callback.h>

#include "server/scenes/services.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

/// The reactor of a new call; it deletes itself. All arguments outlive the call.
grpc::ServerUnaryReactor* start_apply(const scenes::Services& services,
                                      grpc::CallbackServerContext& context,
                                      const v1::ApplyUpdatesRequest& request,
                                      v1::ApplyUpdatesResponse& reply);

}  // namespace sightline::server::updates
