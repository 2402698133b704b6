// The address that a server listens on.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "accel/result.h"

namespace sightline::server::net {

/// The HOST:PORT that a server listens on.
struct ListenAddress {
  std::string host;        ///< A name or an address; an IPv6 address without its brackets.
  std::uint16_t port = 0;  ///< 0: any free one.

  /// Takes HOST:PORT and [IPV6]:PORT. Errors: kInvalidArgument.
  static Result<ListenAddress> parse(std::string_view text);
  /// The form gRPC takes.
  std::string text() const;
  /// Whether only this machine can reach it: 127.0.0.0/8, ::1 or "localhost".
  bool is_loopback() const;
};

}  // namespace sightline::server::net
