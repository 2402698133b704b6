// Whether the process of a server has ended. Internal to the library.
#pragma once

#include <chrono>

#include "client/calls/descriptor.h"

namespace sightline::client::calls {

/// The process at the other end of a Unix socket.
class ServerProcess {
 public:
  /// Unknown, as one of another container is.
  ServerProcess() = default;
  static ServerProcess of_peer(int socket);

  /// Whether it has certainly ended, and its memory is gone: now, or within the time. False if it
  /// is unknown.
  bool has_ended(std::chrono::milliseconds within) const;

 private:
  Descriptor process_;
};

}  // namespace sightline::client::calls
