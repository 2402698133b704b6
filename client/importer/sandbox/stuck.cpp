// The state and processor time of a process, from /proc.
#include "client/importer/sandbox/stuck.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>

namespace sightline::client::importer::sandbox {
namespace {

constexpr int kMostAsleep = 4;

struct ProcessTime {
  char state = 0;
  std::uint64_t ticks = 0;  // in user and in system mode
};

// Reads /proc/PID/stat (see proc(5)): after the name in brackets come the state and ten numbers,
// then the ticks.
std::optional<ProcessTime> time_of(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return {};
  std::istringstream fields(text.substr(name_end + 1));
  ProcessTime time;
  fields >> time.state;
  std::string skipped;
  for (int i = 0; i < 10; ++i) fields >> skipped;
  std::uint64_t user = 0, system = 0;
  if (!(fields >> user >> system)) return {};
  time.ticks = user + system;
  return time;
}

}  // namespace

bool StuckWatch::is_stuck(pid_t child) {
  const std::optional<ProcessTime> time = time_of(child);
  const bool asleep = time && time->state == 'S' && time->ticks == last_ticks_;
  asleep_ = asleep ? asleep_ + 1 : 0;
  if (time) last_ticks_ = time->ticks;
  return asleep_ >= kMostAsleep;
}

}  // namespace sightline::client::importer::sandbox
