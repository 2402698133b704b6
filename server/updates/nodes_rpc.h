// SceneService.BatchGetNodes: nodes of one revision, by id.
#pragma once

#include <grpcpp/support/server_callback.h>

#include "server/scenes/services.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

inline constexpr int kMaxNodesPerRequest =
    512;  ///< A node's name has up to 1 KiB, so the reply stays below 1 MiB.

/// The reactor of a new call; it deletes itself. All arguments outlive the call.
grpc::ServerUnaryReactor* start_get_nodes(const scenes::Services& services,
                                          const grpc::CallbackServerContext& context,
                                          const v1::BatchGetNodesRequest& request,
                                          v1::BatchGetNodesResponse& reply);

}  // namespace sightline::server::updates
