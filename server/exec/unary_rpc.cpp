// Unary calls that run on a worker.
#include "server/exec/unary_rpc.h"

namespace sightline::server::exec {

Status hold_reply(UnreadReplies& unread, grpc::CallbackServerContext& context, const Caller& caller,
                  const google::protobuf::Message& request, const google::protobuf::Message& reply,
                  const Status& status, std::unique_ptr<UnreadReplies::Held>& held) {
  if (!status.ok()) return status;
  // gRPC holds the reply a second time, as bytes.
  auto now = unread.hold(context, caller, request.ByteSizeLong() + 2 * reply.ByteSizeLong());
  if (!now) return now.error();
  held = std::move(*now);
  return {};
}

}  // namespace sightline::server::exec
