// Who makes a call.
#pragma once

#include <grpcpp/server_context.h>

#include <string>
#include <string_view>

namespace sightline::server::exec {

/// The owner of what a call holds.
struct Caller {
  std::string principal;   ///< The principal's name; without one, the peer's address.
  std::string connection;  ///< The peer's address with its port.
};

/// `peer`: as gRPC writes it, "ipv4:127.0.0.1:4711", "ipv6:[::1]:4711" or "unix:path".
Caller caller_of(std::string_view peer);

/// As above, with the name of the call's principal (call_context.h) if it has one. Connections to a
/// Unix socket have no addresses, and get a number.
Caller caller_of(grpc::CallbackServerContext& context);

}  // namespace sightline::server::exec
