// RayQueryService.StreamCastRays: many batches over one call, one at a time.
#pragma once

#include "server/scenes/services.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::server::queries {

/// The reactor of a new call, which already reads; it deletes itself. `services` and `context`
/// outlive the call. The call ends with RESOURCE_EXHAUSTED if services.cast_streams is full.
grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>* start_cast_stream(
    const scenes::Services& services, const grpc::CallbackServerContext& context);

}  // namespace sightline::server::queries
