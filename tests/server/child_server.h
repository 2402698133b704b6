// sightlined as a process of its own.
#pragma once

#include <sys/types.h>

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sightline::tests {

class ChildServer {
 public:
  /// Starts the program with these flags.
  explicit ChildServer(const std::vector<std::string>& flags);
  /// Kills it if it still runs.
  ~ChildServer();

  /// Waits until it serves and returns its port, or 0 if it has ended before.
  int port();
  void signal(int number);
  /// Waits for its end. Returns its exit code, or -1 if a signal has ended it.
  int wait();
  /// What it has written to stdout and stderr so far.
  std::string output();
  std::uint64_t resident_bytes() const;

 private:
  void collect(int fd);

  pid_t pid_ = 0;
  bool waited_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string output_;
  bool closed_ = false;
  std::thread collector_;
};

}  // namespace sightline::tests
