// A running server: its services, stores and workers.
#pragma once

#include <memory>

#include "proto/result.h"
#include "server/config.h"

namespace sightline::server {

class Server {
 public:
  /// What start() checks before it does anything. Errors: kInvalidArgument.
  static Status check(const ServerConfig& config);
  /// Whether certificates and tokens can be read. Errors: as start().
  static Status check_files(const ServerConfig& config);

  /// The server accepts calls when this returns. Errors: kInvalidArgument (not an address, one that
  /// other machines can reach without TLS or `insecure`, or bad certificates or tokens),
  /// kUnavailable (the port cannot be bound), kFailedPrecondition (a file cannot be read, or the
  /// data directory or the port file cannot be written).
  static Result<std::unique_ptr<Server>> start(const ServerConfig& config);
  /// Calls drain().
  ~Server();

  int port() const;        ///< The bound port; 0 for a Unix socket.
  int admin_port() const;  ///< The bound port of ServerConfig::admin; 0 if there is none.

  /// Reads certificates and tokens again, at once, on a thread of its own; a line of the log says
  /// how it ended.
  void reload();

  /// Is not ready from now on (/readyz, the health service), but serves for config.not_ready. Then
  /// refuses new calls, waits up to config.drain for open calls and then cancels them. Returns when
  /// all calls have ended. A second call does nothing. The admin port answers until the end.
  void drain();

 private:
  struct Parts;
  explicit Server(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace sightline::server
