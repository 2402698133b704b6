// Sockets that listen.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "proto/result.h"
#include "server/net/descriptor.h"
#include "server/net/listen_address.h"

namespace sightline::server::net {

/// Removes the file of a Unix socket at its end. Empty: none.
class SocketFile {
 public:
  SocketFile() = default;
  explicit SocketFile(std::string path) : path_(std::move(path)) {}
  SocketFile(SocketFile&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  SocketFile& operator=(SocketFile&& other) noexcept {
    std::swap(path_, other.path_);
    return *this;
  }
  ~SocketFile();

 private:
  std::string path_;
};

/// The sockets of one address: a name may stand for several addresses. They do not block.
struct ListeningSockets {
  std::vector<Descriptor> sockets;
  std::uint16_t port = 0;  ///< The port of all sockets; 0 for a Unix socket.
  SocketFile file = {};
};

/// A Unix socket is open to its owner and group. One that a server left behind is replaced. Errors:
/// kUnavailable, with the system's reason (the name is unknown, the port or the path is in use).
Result<ListeningSockets> listen_on(const ListenAddress& address);

}  // namespace sightline::server::net
