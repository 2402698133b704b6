// RayQueryService.StreamCastRays: many batches over one call, one at a time.
#pragma once

#include <atomic>
#include <cstddef>

#include "server/queries/cast_job.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::server::queries {

/// The reactor of a new call, already reading; it frees itself. `open` counts the calls that are
/// open and, like `services`, outlives them, as `context` does this one; the call ends with
/// RESOURCE_EXHAUSTED if `limit` are open already.
grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>* start_cast_stream(
    const CastServices& services, const grpc::CallbackServerContext& context,
    std::atomic<std::size_t>& open, std::size_t limit);

}  // namespace sightline::server::queries
