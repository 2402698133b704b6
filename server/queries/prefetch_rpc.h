// RayQueryService.Prefetch: one request, and progress until the trees are built.
#pragma once

#include "server/scenes/services.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::server::queries {

/// The reactor of a new call, which has begun; it deletes itself. The arguments outlive
/// the call.
grpc::ServerWriteReactor<v1::PrefetchResponse>* start_prefetch(const scenes::Services& services,
                                                               grpc::CallbackServerContext& context,
                                                               const v1::PrefetchRequest& request);

}  // namespace sightline::server::queries
