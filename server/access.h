// Who may connect: the address, TLS, and tokens.
#pragma once

#include <memory>

#include "proto/result.h"
#include "server/config.h"
#include "server/net/listen_address.h"
#include "server/security/authenticator.h"
#include "server/security/tls.h"

namespace sightline::server {

/// The address to listen on. Errors: kInvalidArgument (not an address, or one that other machines
/// can reach without TLS or `insecure`).
Result<net::ListenAddress> check_listen(const ServerConfig& config);

/// Warns of an address that other machines can reach without encryption or authentication.
void warn_if_exposed(const ServerConfig& config, const net::ListenAddress& address);

struct Access {
  std::unique_ptr<security::Tls> tls;  ///< Null: none.
  std::unique_ptr<security::Authenticator> authenticator;

  /// Reads the files. Errors: kFailedPrecondition, kInvalidArgument, each naming the file.
  static Result<Access> make(const ServerConfig& config);
  /// Reads the files again. What cannot be used is logged, and changes nothing. `asked`: a line of
  /// the log says in any case how it ended.
  void reload(bool asked) const;
};

}  // namespace sightline::server
