// A descriptor of the process, which becomes readable when it has ended.
#include "client/calls/server_process.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace sightline::client::calls {

ServerProcess ServerProcess::of_peer(int socket) {
  ServerProcess process;
  ucred peer{};
  socklen_t size = sizeof peer;
  // A number that another process has by now is no harm: the server has ended before.
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 && peer.pid > 0)
    process.process_ = Descriptor(static_cast<int>(syscall(SYS_pidfd_open, peer.pid, 0)));
  return process;
}

bool ServerProcess::has_ended(std::chrono::milliseconds within) const {
  if (!process_) return false;
  pollfd end{.fd = process_.number(), .events = POLLIN, .revents = 0};
  return poll(&end, 1, static_cast<int>(within.count())) == 1;
}

}  // namespace sightline::client::calls
