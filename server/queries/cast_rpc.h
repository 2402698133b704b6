// RayQueryService.
#pragma once

#include <atomic>
#include <cstddef>

#include "server/exec/message_pool.h"
#include "server/exec/prefetch_calls.h"
#include "server/queries/cast_job.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::server::queries {

/// Open StreamCastRays calls on the whole server: each keeps the memory of one batch.
inline constexpr std::size_t kMaxCastStreams = 256;

class RayQueryRpc final : public v1::RayQueryService::CallbackService {
 public:
  /// At most `max_prefetches` are worked at.
  RayQueryRpc(const CastServices& services, std::size_t max_prefetches);

  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context,
                                     const v1::CastRaysRequest* request,
                                     v1::CastRaysResponse* reply) override;
  grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>* StreamCastRays(
      grpc::CallbackServerContext* context) override;
  grpc::ServerWriteReactor<v1::PrefetchResponse>* Prefetch(
      grpc::CallbackServerContext* context, const v1::PrefetchRequest* request) override;

  /// Ends those that are in work, and refuses others: nobody needs trees of a server that stops.
  void stop_prefetching() { prefetches_.stop(); }

 private:
  const CastServices services_;
  exec::MessagePool<v1::CastRaysRequest, v1::CastRaysResponse> messages_;
  std::atomic<std::size_t> open_streams_{0};
  exec::PrefetchCalls prefetches_;
};

}  // namespace sightline::server::queries
