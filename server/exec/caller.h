// Who makes a call.
#pragma once

#include <grpcpp/server_context.h>

#include <string>
#include <string_view>

namespace sightline::server::exec {

/// The owner of what a call holds.
struct Caller {
  std::string principal;   ///< The peer's address without its port.
  std::string connection;  ///< The peer's address with its port.
};

/// `peer`: as gRPC writes it, "ipv4:127.0.0.1:4711", "ipv6:[::1]:4711" or "unix:path".
Caller caller_of(std::string_view peer);

inline Caller caller_of(const grpc::ServerContextBase& context) {
  return caller_of(context.peer());
}

}  // namespace sightline::server::exec
