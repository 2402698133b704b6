// The address that a server listens on.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "proto/result.h"

namespace sightline::server::net {

/// The port, or the Unix socket, that a server listens on.
struct ListenAddress {
  std::string host = {};   ///< A name or an address; an IPv6 address without its brackets.
  std::uint16_t port = 0;  ///< 0: any free one.
  std::string path = {};   ///< The path of a Unix socket, which has no host and port. Empty: none.

  /// Takes HOST:PORT, [IPV6]:PORT and unix:PATH. Errors: kInvalidArgument.
  static Result<ListenAddress> parse(std::string_view text);
  /// The form that gRPC takes.
  std::string text() const;
  bool is_unix() const { return !path.empty(); }
  /// Whether only this machine can reach it: a Unix socket, 127.0.0.0/8, ::1 or "localhost".
  bool is_local() const;
};

}  // namespace sightline::server::net
