// RayQueryService.Prefetch: one request, and progress until the trees are built.
#pragma once

#include "server/exec/prefetch_calls.h"
#include "server/queries/cast_job.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::server::queries {

/// The reactor of a new call, already at work; it frees itself. `calls` outlives it, as `services`
/// does.
grpc::ServerWriteReactor<v1::PrefetchResponse>* start_prefetch(const CastServices& services,
                                                               exec::PrefetchCalls& calls,
                                                               const v1::PrefetchRequest& request);

}  // namespace sightline::server::queries
