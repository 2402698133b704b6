// The Unix socket at which clients get the descriptors of segments.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include "server/net/descriptor.h"
#include "server/segments/handover_keys.h"
#include "server/segments/segment.h"

struct pollfd;

namespace sightline::server::segments {

/// Listens in the abstract namespace, by a name that cannot be guessed, on a thread of its own. Who
/// connects and sends a key that is good gets one byte with the descriptor; who sends anything else
/// gets nothing, and the connection is closed. A client that has sent its key when it is accepted
/// does not wait for others. Of those that have not there are few: where one more comes, the oldest
/// of the user who has most is closed, and any is after kKeyTimeout.
///
/// The connection of a client that has got its segment stays open as long as the client has it
/// mapped, and keeps the segment. The system closes it for a client that dies. There are no more of
/// them than segments, as a key is good once.
class Handover {
 public:
  /// Connections whose keys have not come. A client sends its key at once.
  static constexpr std::size_t kMaxWaiting = 32;
  static constexpr std::chrono::seconds kKeyTimeout{2};

  /// Listens from now on. `keys` outlive this object. Throws std::system_error if the system
  /// refuses the socket or the thread.
  explicit Handover(HandoverKeys& keys);
  ~Handover();
  Handover(const Handover&) = delete;
  Handover& operator=(const Handover&) = delete;

  /// The name of the socket, without the zero byte before it.
  const std::string& name() const { return name_; }

 private:
  using Clock = std::chrono::steady_clock;
  /// A connection whose key has not come in full.
  struct Waiting {
    net::Descriptor connection;
    std::string user;
    Clock::time_point until;
    HandoverKeys::Key key{};
    std::size_t received = 0;
  };

  /// A client that has got its segment.
  struct Served {
    net::Descriptor connection;
    std::shared_ptr<const Segment> segment;
  };

  void run();
  int wait_ms() const;
  void accept_some();
  void take(net::Descriptor connection);
  bool serve(Waiting& one);
  void let_go(std::span<const pollfd> of_served);
  void close_oldest_for(const std::string& user);

  HandoverKeys& keys_;
  std::string name_;
  net::Descriptor listener_, wake_;
  std::list<Waiting> waiting_;  // oldest first
  std::list<Served> served_;    // oldest first
  std::thread thread_;          // last: uses the members above
};

}  // namespace sightline::server::segments
