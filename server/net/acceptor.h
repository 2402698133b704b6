// Accepts connections, whatever the process runs out of.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "server/exec/token_bucket.h"
#include "server/net/connections.h"
#include "server/net/descriptor.h"

namespace sightline::server::net {

/// gRPC 1.51 accepts nothing any more once accept() has failed for want of file descriptors
/// (CVE-2023-4785), so connections are accepted here and handed over. A connection over the limit
/// is closed at once. A second descriptor of every socket tells when the connection is gone.
///
/// Each connection costs a handshake, with TLS a millisecond. So connections of one address are
/// handed over at a pace: those that come faster wait, the longer the more connections of the
/// address were ended for what they sent.
class Acceptor {
 public:
  /// How many connections of one address are handed over a second, and at once.
  static constexpr std::uint64_t kPerSecond = 500;
  /// A connection that was ended counts as this number of them.
  static constexpr std::uint64_t kPerEnded = 100;
  static constexpr std::chrono::seconds kLongestWait{10};

  struct Events {
    /// Takes a connection that does not block. Must not throw.
    std::function<void(int listener, Descriptor connection)> accepted;
    /// Nothing is accepted any more, but stop() was not called.
    std::function<void()> failed;
    /// The addresses of connections that were ended for what they sent since the last call. Null:
    /// none.
    std::function<std::vector<std::string>()> ended = nullptr;
  };

  /// Accepts from now on. `limit`: connections open at a time, >= 1.
  Acceptor(std::vector<Descriptor> listeners, std::size_t limit, Events events);
  /// Calls stop().
  ~Acceptor();

  /// Accepts nothing any more and closes the listening sockets. Open connections stay. A second
  /// call does nothing. Threads: one at a time.
  void stop();
  /// Shuts down the connections that are still open. Call it after stop().
  void shut_down() { connections_.shut_down(); }

 private:
  void run();
  bool is_listener(int descriptor) const;
  void drop(int connection);
  void accept_from(int listener);
  void refuse_from(int listener);
  void take(int listener, Descriptor connection);
  void hand_over_waiting();
  exec::TokenBucket& pace_of(const std::string& address);
  void watch(int descriptor, unsigned events);

  std::vector<Descriptor> listeners_;
  const Events events_;
  Connections connections_;
  struct Waiting {
    int listener, number;  // `number`: the second descriptor
    std::string address;
    Descriptor connection;
  };
  std::list<Waiting> waiting_;                      // oldest first
  std::map<std::string, exec::TokenBucket> paces_;  // addresses that connected lately
  Descriptor epoll_, wake_;
  Descriptor reserve_;  // given up for a moment to refuse a connection when there are no more
  std::thread thread_;
};

/// How many connections may be open, by the process's limit of file descriptors, which is raised
/// as far as the system allows.
std::size_t connection_limit();

}  // namespace sightline::server::net
