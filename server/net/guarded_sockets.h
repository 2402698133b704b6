// Puts a FrameGuard between a socket and gRPC, without a copy.
#pragma once

#include <cstddef>
#include <memory>

#include "server/net/ended_connections.h"

namespace sightline::server::net {

/// gRPC 1.51 offers no place to look at what it reads. So the program has its own recvmsg(),
/// sendmsg() and close(), and SSL_read() and SSL_write() for connections with TLS, which a shared
/// gRPC calls instead of the libraries' functions. They look at guarded sockets, and pass every
/// other call on.
///
/// A connection that has to end gets PING frames instead of what its client sent: gRPC answers too
/// many of them with GOAWAY (ENHANCE_YOUR_CALM), ends the calls and closes the socket.
struct GuardSettings {
  std::size_t max_streams = 0;  ///< Calls at a time that the server's settings allow.
  bool tls = false;
  std::shared_ptr<EndedConnections> ended;
};

/// Guards the socket from now on until close() is called with its number. False: its number is too
/// large. Threads: any; nothing may be read or written meanwhile.
bool guard_socket(int socket, const GuardSettings& settings);

/// While it lives, a TLS connection that this thread makes for a server is that of the socket.
class TlsOf {
 public:
  explicit TlsOf(int socket);
  ~TlsOf();
  TlsOf(const TlsOf&) = delete;
  TlsOf& operator=(const TlsOf&) = delete;
};

}  // namespace sightline::server::net
