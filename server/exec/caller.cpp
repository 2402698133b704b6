// Who makes a call.
#include "server/exec/caller.h"

#include <fmt/format.h>
#include <grpc/grpc_security.h>

#include <memory>

#include "server/exec/call_context.h"

namespace sightline::server::exec {
namespace {

/// gRPC keeps one such object for each connection, as long as it is open.
const void* connection_object(grpc::CallbackServerContext& context) {
  const std::unique_ptr<grpc_auth_context, decltype(&grpc_auth_context_release)> object(
      grpc_call_auth_context(context.c_call()), grpc_auth_context_release);
  return object.get();  // NOLINT(clang-diagnostic-return-stack-address): it is on the heap
}

}  // namespace

Caller caller_of(std::string_view peer) {
  const std::size_t port = peer.starts_with("ip") ? peer.rfind(':') : std::string_view::npos;
  return {std::string(peer.substr(0, port)), std::string(peer)};
}

Caller caller_of(grpc::CallbackServerContext& context) {
  Caller caller = caller_of(context.peer());
  if (caller.connection.starts_with("unix:"))
    caller.connection = fmt::format("unix:{}", connection_object(context));
  if (const Principal* principal = principal_of(context)) caller.principal = principal->name;
  return caller;
}

}  // namespace sightline::server::exec
