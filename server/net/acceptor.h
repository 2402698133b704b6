// Accepts connections, whatever the process runs out of.
#pragma once

#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

#include "server/net/connections.h"
#include "server/net/descriptor.h"

namespace sightline::server::net {

/// gRPC 1.51 accepts nothing any more once accept() has failed for want of file descriptors
/// (CVE-2023-4785), so connections are accepted here and handed over. A connection over the limit
/// is closed at once. A second descriptor of every socket tells when the connection is gone.
class Acceptor {
 public:
  struct Events {
    /// Takes a connection that does not block. Must not throw.
    std::function<void(int listener, Descriptor connection)> accepted;
    /// Nothing is accepted any more, but stop() was not called.
    std::function<void()> failed;
  };

  /// Accepts from now on. `limit`: connections open at a time, >= 1.
  Acceptor(std::vector<Descriptor> listeners, std::size_t limit, Events events);
  /// Calls stop().
  ~Acceptor();

  /// Accepts nothing any more and closes the listening sockets. Open connections stay. A second
  /// call does nothing. Threads: one at a time.
  void stop();
  /// After stop(): shuts down the connections that are still open.
  void shut_down() { connections_.shut_down(); }

 private:
  void run();
  bool is_listener(int descriptor) const;
  void drop(int connection);
  void accept_from(int listener);
  void refuse_from(int listener);
  void take(int listener, Descriptor connection);
  void watch(int descriptor, unsigned events);

  std::vector<Descriptor> listeners_;
  const Events events_;
  Connections connections_;
  Descriptor epoll_, wake_;
  Descriptor reserve_;  // given up for a moment to refuse a connection when there are no more
  std::thread thread_;
};

/// How many connections may be open, by the process's limit of file descriptors, which is raised
/// as far as the system allows.
std::size_t connection_limit();

}  // namespace sightline::server::net
