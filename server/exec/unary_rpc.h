// Unary calls that run on a worker, do not wait, and ignore cancellation.
#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>

#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>

#include "server/exec/admission.h"
#include "server/exec/caller.h"
#include "server/exec/executors.h"
#include "server/exec/quotas.h"
#include "server/exec/rpc_status.h"
#include "server/exec/unread_replies.h"

namespace sightline::server::exec {

/// What unary calls use. Each part outlives every call.
struct UnaryParts {
  Compute& compute;
  Admission& admission;
  UnreadReplies& unread;
  Quotas& quotas;
};

/// Call it before a reply is handed to gRPC. Sets `held` to what accounts for it until the peer has
/// read it. Returns `status`, or the error if too much is unread; nothing is held for an error.
Status hold_reply(UnreadReplies& unread, grpc::CallbackServerContext& context, const Caller& caller,
                  const google::protobuf::Message& request, const google::protobuf::Message& reply,
                  const Status& status, std::unique_ptr<UnreadReplies::Held>& held);

/// On which workers a call is answered.
enum class WorkKind : std::uint8_t {
  kShort,  ///< With other short calls, in order of arrival.
  kLong,   ///< In turn with queries and uploads of others, so that no short call waits for it.
};

/// A call, which lives until its reply is read. Deletes itself.
template <class Work>
class UnaryCall final : public grpc::ServerUnaryReactor {
 public:
  UnaryCall(std::string_view method, grpc::CallbackServerContext& context,
            const google::protobuf::Message& request, const google::protobuf::Message& reply,
            const UnaryParts& parts, Work work)
      : method_(method),
        context_(context),
        caller_(caller_of(context)),
        request_(request),
        reply_(reply),
        parts_(parts),
        work_(std::move(work)) {}

  void start(WorkKind kind) {
    auto work = parts_.quotas.begin_work(caller_, 0, request_.ByteSizeLong());
    if (!work) return Finish(to_grpc(work.error()));
    quota_ = std::move(*work);
    auto admitted = parts_.admission.admit(caller_, 0, request_.SpaceUsedLong());
    if (!admitted) return Finish(to_grpc(admitted.error()));
    ticket_ = std::move(*admitted);
    if (kind == WorkKind::kLong) {
      parts_.compute.enqueue_work(caller_, [this] { answer(); });
    } else {
      parts_.compute.enqueue_management([this] { answer(); });
    }
  }

  void OnDone() override { delete this; }

 private:
  void answer() {
    const Status done =
        hold_reply(parts_.unread, context_, caller_, request_, reply_, to_status(work_), held_);
    const grpc::Status status = to_grpc(done);
    ticket_ = {};
    quota_ = {};
    log_rpc(method_, context_, status, begun_);
    Finish(status);  // may delete this reactor
  }

  const LogClock::time_point begun_ = LogClock::now();
  const std::string_view method_;
  grpc::CallbackServerContext& context_;
  const Caller caller_;
  const google::protobuf::Message& request_;
  const google::protobuf::Message& reply_;
  const UnaryParts parts_;
  Work work_;
  Admission::Ticket ticket_;
  Quotas::Use quota_;
  std::unique_ptr<UnreadReplies::Held> held_;
};

/// Runs work() on a worker and ends the call with the Status it returns. The bytes of the request
/// are admitted first, and the reply is held until it is read.
template <class Work>
grpc::ServerUnaryReactor* answer_in_arena(std::string_view method,
                                          grpc::CallbackServerContext& context,
                                          const google::protobuf::Message& request,
                                          const google::protobuf::Message& reply,
                                          const UnaryParts& parts, Work work,
                                          WorkKind kind = WorkKind::kShort) {
  auto* call = new UnaryCall<Work>(method, context, request, reply, parts, std::move(work));
  call->start(kind);
  return call;
}

}  // namespace sightline::server::exec
