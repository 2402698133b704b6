// The other end of a remote measurement: a server in a process of its own.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "proto/result.h"
#include "tests/support/child_process.h"

namespace sightline::bench {

/// All threads of a process run on this processor alone, or, if it is kAnyProcessor, on all.
/// Errors: kFailedPrecondition.
inline constexpr int kAnyProcessor = -1;
Status pin_process(pid_t process, int processor);

/// Seconds of processor time that all threads of a process have used, in the kernel too.
double processor_seconds(pid_t process);

/// Threads: one.
class PeerProcess {
 public:
  /// Ends the process, and removes its Unix socket.
  ~PeerProcess();
  PeerProcess(const PeerProcess&) = delete;
  PeerProcess& operator=(const PeerProcess&) = delete;

  /// The server of this build, with this number of workers for queries, at a port or at a Unix
  /// socket.
  static Result<std::unique_ptr<PeerProcess>> start_server(int threads, bool unix_socket = false);
  /// The service of echo_service.h, at its port or at its Unix socket.
  static Result<std::unique_ptr<PeerProcess>> start_echo(bool unix_socket = false);

  const std::string& endpoint() const { return endpoint_; }
  pid_t id() const { return process_.id(); }
  double processor_seconds() const { return bench::processor_seconds(process_.id()); }

 private:
  PeerProcess(const std::string& program, const std::vector<std::string>& arguments)
      : process_(program, arguments) {}
  static Result<std::unique_ptr<PeerProcess>> start(const std::string& program,
                                                    const std::vector<std::string>& arguments);
  void use_socket(const std::string& path);

  std::string socket_;  // a path; empty: it has none
  tests::ChildProcess process_;
  std::string endpoint_;
};

}  // namespace sightline::bench
