// Ends a process that does not end by itself.
#include "server/watchdog.h"

#include <poll.h>
#include <unistd.h>

#include <string_view>
#include <thread>

#include "server/exec/arena_priority.h"

namespace sightline::server {
namespace {

constexpr std::string_view kMessage =
    "sightlined: did not end in time after the drain, and was ended by its watchdog\n";

/// Writes a line to stderr if it fits into the pipe: not through the log, which may be what has
/// stopped.
void say_why() {
  pollfd standard_error{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  if (poll(&standard_error, 1, 0) != 1 || (standard_error.revents & POLLOUT) == 0) return;
  [[maybe_unused]] const auto written = write(STDERR_FILENO, kMessage.data(), kMessage.size());
}

}  // namespace

Watchdog::Watchdog() { std::thread(&Watchdog::watch, this).detach(); }

void Watchdog::arm(std::chrono::milliseconds limit) {
  limit_ = limit;
  armed_.release();
}

void Watchdog::watch() {
  armed_.acquire();
  std::this_thread::sleep_for(limit_);
  say_why();
  exec::restore_niceness();
  _exit(0);
}

}  // namespace sightline::server
