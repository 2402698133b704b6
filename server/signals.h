// What the program does on signals.
#pragma once

#include <signal.h>

#include <functional>

namespace sightline::server {

/// Takes signals from its construction on. Make it first of all: threads that start later inherit
/// its mask. SIGTERM, SIGINT and SIGHUP wait for wait_for_end(). Signals that would end the process
/// by default, and that are meant for programs of other kinds, are ignored: SIGUSR1, SIGUSR2,
/// SIGPIPE, SIGALRM, SIGVTALRM, SIGPROF, SIGIO, SIGPWR, SIGSTKFLT and the real-time signals. All
/// others, such as SIGQUIT, which leaves a core dump, do what they do by default.
class Signals {
 public:
  Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  /// SIGTERM, SIGINT and SIGHUP end the process again: for a program that only checks something.
  void let_go() const;

  /// Waits for SIGTERM or SIGINT, and returns it. For each SIGHUP before it calls on_hangup().
  int wait_for_end(const std::function<void()>& on_hangup) const;

 private:
  sigset_t awaited_{};
};

}  // namespace sightline::server
