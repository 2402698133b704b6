// The sightline command as a process of its own, to be interrupted.
#pragma once

#include <sys/types.h>

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sightline::tests {

class ChildProgram {
 public:
  /// Starts it with these arguments; its standard input never says anything.
  explicit ChildProgram(const std::vector<std::string>& arguments);
  /// Kills it if it still runs.
  ~ChildProgram();

  /// Waits until it has written this text to stdout or stderr; false if it has ended without.
  bool writes(const std::string& text);
  /// Waits until it catches SIGINT itself; false if it has ended before.
  bool catches_interrupts();
  void interrupt();
  /// Waits for its end. Returns its exit code, or -1 if a signal has ended it.
  int wait();
  /// What it has written so far.
  std::string output();

 private:
  void collect();

  pid_t pid_ = 0;
  int out_ = -1, silence_ = -1;
  bool waited_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string output_;
  bool closed_ = false;
  std::thread collector_;
};

}  // namespace sightline::tests
