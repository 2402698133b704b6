// RayQueryService: batches of rays and of points, streams of batches, prefetches, and segments.
#pragma once

#include <cstddef>

#include "server/exec/message_pool.h"
#include "server/queries/cast_job.h"
#include "server/scenes/services.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::server::queries {

/// Open StreamCastRays and StreamQueryPoints calls on the whole server. Each keeps the memory of
/// one batch.
inline constexpr std::size_t kMaxCastStreams = 256;

class RayQueryRpc : public v1::RayQueryService::CallbackService {
 public:
  explicit RayQueryRpc(const scenes::Services& services);

  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context,
                                     const v1::CastRaysRequest* request,
                                     v1::CastRaysResponse* reply) override;
  grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>* StreamCastRays(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* QueryPoints(grpc::CallbackServerContext* context,
                                        const v1::QueryPointsRequest* request,
                                        v1::QueryPointsResponse* reply) override;
  grpc::ServerBidiReactor<v1::StreamQueryPointsRequest, v1::StreamQueryPointsResponse>*
  StreamQueryPoints(grpc::CallbackServerContext* context) override;
  grpc::ServerWriteReactor<v1::PrefetchResponse>* Prefetch(
      grpc::CallbackServerContext* context, const v1::PrefetchRequest* request) override;
  grpc::ServerWriteReactor<v1::OpenSegmentResponse>* OpenSegment(
      grpc::CallbackServerContext* context, const v1::OpenSegmentRequest* request) override;

 private:
  const scenes::Services services_;
  exec::MessagePool<v1::CastRaysRequest, v1::CastRaysResponse> messages_;
  exec::MessagePool<v1::QueryPointsRequest, v1::QueryPointsResponse> point_messages_;
};

}  // namespace sightline::server::queries
