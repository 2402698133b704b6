// The command as a process of its own, which a test talks with through pipes.
#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>
#include <vector>

namespace sightline::tests {

class Coprocess {
 public:
  /// Starts the command with these arguments. It inherits the environment and stderr.
  explicit Coprocess(const std::vector<std::string>& arguments);
  Coprocess(const Coprocess&) = delete;
  Coprocess& operator=(const Coprocess&) = delete;
  ~Coprocess();

  void write(std::string_view bytes) const;
  /// The next line with its end; shorter at the end of output, or if none came for a minute.
  std::string read_line();
  /// The next n bytes; fewer as above.
  std::string read_bytes(std::size_t n);
  void close_input();
  /// What is left of the output.
  std::string read_rest();
  /// Waits for the end, and returns the exit code; -1: a signal.
  int wait();
  pid_t pid() const { return pid_; }

 private:
  bool read_more();

  pid_t pid_ = -1;
  int to_ = -1;
  int from_ = -1;
  std::string buffer_;
};

}  // namespace sightline::tests
