// A program in a separate process: its output, its exit code, its reaction to signals.
#pragma once

#include <sys/types.h>

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sightline::tests {

class ChildProcess {
 public:
  /// Starts the program, given as a path, with these arguments and a silent standard input. Throws
  /// std::system_error.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments);
  /// Kills the program if it is still running.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits until the program has written this text to stdout or stderr; false if it ended without
  /// writing it.
  bool writes(const std::string& text);
  /// Waits for this text and the end of its line, and returns the text between; empty if the
  /// program ended without writing it.
  std::string rest_of_line(const std::string& text);
  /// Reads no more of its output, but for a few KiB, until read_on() or its end.
  void stop_reading();
  void read_on();
  /// Waits until the program handles the signal itself; false if it ended before.
  bool catches(int signal);
  void signal(int number);
  pid_t id() const { return pid_; }
  /// Waits for its end. Returns its exit code, or -1 if a signal ended it.
  int wait();
  /// Its output so far.
  std::string output();
  std::uint64_t resident_bytes() const;
  /// The most that was resident at any time.
  std::uint64_t peak_resident_bytes() const;
  /// Files and sockets that it has open.
  std::uint64_t open_files() const;

 private:
  void collect();

  pid_t pid_ = 0;
  int written_ = -1, silence_ = -1;
  bool waited_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string output_;
  bool closed_ = false, reading_ = true;
  std::thread collector_;
};

}  // namespace sightline::tests
