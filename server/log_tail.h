// The last lines of the log, for those who watch the server.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::server {

/// Threads: any, for every member.
class LogTail {
 public:
  static constexpr std::size_t kLines = 500;
  static constexpr std::size_t kMaxLine = 1024;  ///< Bytes; a longer line is cut.

  /// Adds a line without its line break. Bytes that are not ASCII are shown as "?".
  void add(std::string_view line);

  struct Lines {
    std::uint64_t first = 0;  ///< The number of the first line; the first line ever has 1.
    std::vector<std::string> lines;
  };
  /// The kept lines with greater numbers.
  Lines after(std::uint64_t number) const;

 private:
  mutable std::mutex mutex_;
  std::uint64_t last_ = 0;
  std::deque<std::string> lines_;
};

/// The tail of this process's log.
LogTail& log_tail();

}  // namespace sightline::server
