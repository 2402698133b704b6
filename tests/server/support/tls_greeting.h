// A TLS handshake by OpenSSL itself, which shows what gRPC's clients do not.
#pragma once

#include <string>

namespace sightline::tests {

/// How a handshake ended, by what the client saw.
struct TlsGreeting {
  bool done = false;
  bool asked = false;            ///< The server wanted a certificate of the client.
  bool hung_up = false;          ///< The server closed the connection before it was done.
  std::string certificate = {};  ///< The server's, as PEM.
};

/// Connects to this port of the machine, has no certificate, and verifies none. `version`: the only
/// one that is offered, such as TLS1_2_VERSION.
TlsGreeting greet_by_tls(int port, int version);

}  // namespace sightline::tests
