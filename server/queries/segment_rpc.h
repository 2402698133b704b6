// RayQueryService.OpenSegment: a call that is open as long as its segment.
#pragma once

#include "server/scenes/services.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::server::queries {

/// The reactor of a new call, which has begun; it deletes itself. The arguments outlive the call.
grpc::ServerWriteReactor<v1::OpenSegmentResponse>* start_segment(
    const scenes::Services& services, grpc::CallbackServerContext& context,
    const v1::OpenSegmentRequest& request);

}  // namespace sightline::server::queries
