// The open connections, at most a limit, shared fairly by the addresses that they come from.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/net/descriptor.h"

namespace sightline::server::net {

/// Threads: one at a time.
class Connections {
 public:
  explicit Connections(std::size_t limit) : limit_(limit) {}

  bool full() const { return size() >= limit_; }

  /// The descriptor of the connection that gives way to one from `address` when all are taken: the
  /// newest one of the address that has most, if that is at least two more than `address` has.
  std::optional<int> gives_way_to(const std::string& address) const;

  /// `socket`: another descriptor of the connection's socket, by which it is shut down.
  void add(const std::string& address, Descriptor socket);

  /// Removes the connection that was added with this descriptor. Does nothing for another number.
  void remove(int socket);

  /// Shuts all connections down.
  void shut_down();

  std::size_t size() const { return addresses_.size(); }

 private:
  using Sockets = std::vector<Descriptor>;  // oldest first

  const std::size_t limit_;
  std::map<std::string, Sockets> by_address_;
  std::map<int, std::string> addresses_;
};

}  // namespace sightline::server::net
