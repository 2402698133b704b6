// The last lines of the log, for those who watch the server.
#include "server/log_tail.h"

#include <algorithm>

#include "proto/printable.h"

namespace sightline::server {

void LogTail::add(std::string_view line) {
  line = line.substr(0, line.find_last_not_of("\r\n") + 1);
  std::string kept = printable(line.substr(0, kMaxLine));
  const std::lock_guard lock(mutex_);
  ++last_;
  lines_.push_back(std::move(kept));
  if (lines_.size() > kLines) lines_.pop_front();
}

LogTail::Lines LogTail::after(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  const std::uint64_t oldest = last_ - lines_.size() + 1;
  const std::uint64_t first = std::max(std::min(number, last_) + 1, oldest);
  Lines read{.first = first, .lines = {}};
  read.lines.assign(lines_.begin() + static_cast<std::ptrdiff_t>(first - oldest), lines_.end());
  return read;
}

LogTail& log_tail() {
  static LogTail tail;
  return tail;
}

}  // namespace sightline::server
