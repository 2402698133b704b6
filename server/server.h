// A running server: its services, stores and workers, from start to drained.
#pragma once

#include <memory>

#include "accel/result.h"
#include "server/config.h"

namespace sightline::server {

class Server {
 public:
  /// Serving when it returns. Errors: kInvalidArgument (a listen address that is no address, or
  /// that other machines can reach without `insecure`), kUnavailable (the port cannot be bound),
  /// kFailedPrecondition (the data directory or the port file cannot be written).
  static Result<std::unique_ptr<Server>> start(const ServerConfig& config);
  /// Drains.
  ~Server();

  int port() const;  ///< The bound one.

  /// Turns the health service to NOT_SERVING, takes no new calls, gives open ones config.drain to
  /// end and then cancels them. Returns when all have ended. A second call does nothing.
  void drain();

 private:
  struct Parts;
  explicit Server(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace sightline::server
