// SceneService.ApplyUpdates: applies one batch on the scene's write queue.
#include "server/updates/apply_rpc.h"

#include <memory>
#include <utility>

#include "server/exec/arena_messages.h"
#include "server/exec/rpc_status.h"
#include "server/updates/apply_job.h"

namespace sightline::server::updates {
namespace {

class ApplyCall final : public grpc::ServerUnaryReactor {
 public:
  ApplyCall(const scenes::Services& services, grpc::CallbackServerContext& context,
            const v1::ApplyUpdatesRequest& request, v1::ApplyUpdatesResponse& reply)
      : services_(services),
        context_(context),
        caller_(exec::caller_of(context)),
        request_(request),
        reply_(reply),
        job_(services, context, request.scene(), request, reply) {}

  void start() {
    auto work = services_.quotas.begin_work(caller_, 0, request_.ByteSizeLong());
    if (!work) return end(work.error());
    quota_ = std::move(*work);
    if (const Status admitted = job_.admit(exec::bytes_on_arena(request_)); !admitted)
      return end(admitted);
    job_.enqueue([this](const Result<AppliedAt>& applied) {
      end(applied ? Status() : Status(applied.error()));
    });
  }

  void OnCancel() override { job_.cancel(); }
  void OnDone() override { delete this; }

 private:
  void end(const Status& status) {
    // The update is applied: an error would say that it is not.
    if (status.ok()) {
      held_ = services_.unread.hold_in_any_case(
          context_, caller_, request_.ByteSizeLong() + 2 * reply_.ByteSizeLong());
    }
    const grpc::Status answer = exec::to_grpc(status);
    quota_ = {};
    exec::log_rpc("ApplyUpdates", context_, answer, begun_);
    Finish(answer);  // may delete this reactor
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  const v1::ApplyUpdatesRequest& request_;
  v1::ApplyUpdatesResponse& reply_;
  std::unique_ptr<exec::UnreadReplies::Held> held_;
  exec::Quotas::Use quota_;
  ApplyJob job_;
};

}  // namespace

grpc::ServerUnaryReactor* start_apply(const scenes::Services& services,
                                      grpc::CallbackServerContext& context,
                                      const v1::ApplyUpdatesRequest& request,
                                      v1::ApplyUpdatesResponse& reply) {
  auto* call = new ApplyCall(services, context, request, reply);
  call->start();
  return call;
}

}  // namespace sightline::server::updates
