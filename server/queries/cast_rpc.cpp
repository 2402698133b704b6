// RayQueryService, and its unary call.
#include "server/queries/cast_rpc.h"

#include <memory>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/queries/prefetch_rpc.h"
#include "server/queries/stream_cast_rpc.h"

namespace sightline::server::queries {
namespace {

/// Lives until its task has called Finish(), also if the client has cancelled the call.
class CastRaysReactor final : public grpc::ServerUnaryReactor {
 public:
  CastRaysReactor(const scenes::Services& services, v1::CastRaysResponse& reply)
      : compute_(services.compute),
        job_(services, Replies::kOne),
        wait_(std::make_shared<scenes::RevisionWait>(services.compute, services.admission,
                                                     services.waiting_reads)),
        reply_(reply) {}

  void start(const grpc::CallbackServerContext& context, const v1::CastRaysRequest& request) {
    if (const Status opened = exec::to_status([&] { return job_.open(request); }); !opened)
      return end(opened);
    wait_->read(job_.scene(), request.consistency(), context.deadline(), request.ByteSizeLong(),
                [this, &request](Result<scenes::RevisionWait::SnapshotPointer> pinned) {
                  if (!pinned) return end(pinned.error());
                  job_.pin(std::move(*pinned));
                  cast(request);
                });
  }

  void OnCancel() override {
    job_.cancel();
    wait_->cancel();
  }
  void OnDone() override { delete this; }

 private:
  void cast(const v1::CastRaysRequest& request) {
    if (const Status accepted = exec::to_status([&] { return job_.accept(request.rays()); });
        !accepted)
      return end(accepted);
    compute_.enqueue([this] {
      const Status done = exec::to_status([this] { return job_.run(reply_); });
      job_.close();
      end(done);
    });
  }

  void end(const Status& status) {
    const grpc::Status answer = exec::to_grpc(status);
    exec::log_rpc("CastRays", answer, begun_);
    Finish(answer);  // may delete this reactor
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  exec::Compute& compute_;
  CastJob job_;
  const std::shared_ptr<scenes::RevisionWait> wait_;
  v1::CastRaysResponse& reply_;
};

}  // namespace

RayQueryRpc::RayQueryRpc(const scenes::Services& services) : services_(services) {
  SetMessageAllocatorFor_CastRays(&messages_);
}

grpc::ServerUnaryReactor* RayQueryRpc::CastRays(grpc::CallbackServerContext* context,
                                                const v1::CastRaysRequest* request,
                                                v1::CastRaysResponse* reply) {
  auto* reactor = new CastRaysReactor(services_, *reply);
  reactor->start(*context, *request);
  return reactor;
}

grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>*
RayQueryRpc::StreamCastRays(grpc::CallbackServerContext* context) {
  return start_cast_stream(services_, *context);
}

grpc::ServerWriteReactor<v1::PrefetchResponse>* RayQueryRpc::Prefetch(
    grpc::CallbackServerContext*, const v1::PrefetchRequest* request) {
  return start_prefetch(services_, *request);
}

}  // namespace sightline::server::queries
