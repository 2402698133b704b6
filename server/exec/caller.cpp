// Who makes a call.
#include "server/exec/caller.h"

#include <fmt/format.h>
#include <grpc/grpc_security.h>

#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>

#include "server/exec/call_context.h"
#include "server/exec/made_for.h"

namespace sightline::server::exec {
namespace {

/// A secret of this process, which no caller outside can know.
const std::string& secret() {
  static const std::string kMade = [] {
    std::random_device random;
    return fmt::format("{:08x}{:08x}{:08x}{:08x} ", random(), random(), random(), random());
  }();
  return kMade;
}

/// The peer that made_for() has named.
std::optional<std::string> named_peer(const grpc::CallbackServerContext& context) {
  const auto found = context.client_metadata().find(kMadeFor);
  if (found == context.client_metadata().end()) return {};
  const std::string_view value(found->second.data(), found->second.size());
  if (!value.starts_with(secret())) return {};
  return std::string(value.substr(secret().size()));
}

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

std::string made_for(std::string_view peer) { return secret() + std::string(peer); }

Caller caller_of(grpc::CallbackServerContext& context) {
  const std::optional<std::string> other = named_peer(context);
  Caller caller = caller_of(other ? *other : context.peer());
  if (!other && caller.connection.starts_with("unix:"))
    caller.connection = fmt::format("unix:{}", connection_object(context));
  if (const Principal* principal = principal_of(context)) caller.principal = principal->name;
  return caller;
}

}  // namespace sightline::server::exec
