// Unary calls that run on a worker, do not wait, and ignore cancellation.
#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>

#include <string_view>
#include <utility>

#include "server/exec/admission.h"
#include "server/exec/executors.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::exec {

/// Runs work() on a worker and ends the call with the Status it returns. The bytes of the request
/// are admitted first.
template <class Work>
grpc::ServerUnaryReactor* answer_in_arena(std::string_view method,
                                          grpc::CallbackServerContext& context,
                                          const google::protobuf::Message& request,
                                          Compute& compute, Admission& admission, Work work) {
  grpc::ServerUnaryReactor* reactor = context.DefaultReactor();
  auto admitted = admission.admit(0, request.SpaceUsedLong());
  if (!admitted) {
    reactor->Finish(to_grpc(admitted.error()));
    return reactor;
  }
  compute.enqueue_management([=, begun = LogClock::now(), ticket = std::move(*admitted),
                              work = std::move(work)]() mutable {
    const grpc::Status status = to_grpc(to_status(work));
    ticket = {};
    log_rpc(method, status, begun);
    reactor->Finish(status);
  });
  return reactor;
}

}  // namespace sightline::server::exec
