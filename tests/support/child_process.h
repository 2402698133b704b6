// A program as a process of its own: what it writes, how it ends, what it does on signals.
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
  /// Starts the program, a path, with these arguments; its standard input never says anything.
  /// Throws std::system_error.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments);
  /// Kills it if it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits until it has written this text to stdout or stderr; false if it has ended without.
  bool writes(const std::string& text);
  /// Waits for this text and the end of its line, and returns what is between; empty if the program
  /// has ended without.
  std::string rest_of_line(const std::string& text);
  /// Waits until it catches the signal itself; false if it has ended before.
  bool catches(int signal);
  void signal(int number);
  /// Waits for its end. Returns its exit code, or -1 if a signal has ended it.
  int wait();
  /// What it has written so far.
  std::string output();
  std::uint64_t resident_bytes() const;

 private:
  void collect();

  pid_t pid_ = 0;
  int written_ = -1, silence_ = -1;
  bool waited_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string output_;
  bool closed_ = false;
  std::thread collector_;
};

}  // namespace sightline::tests
