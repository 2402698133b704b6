// What the process uses, under the names that Prometheus' own libraries use.
#include "server/metrics/process.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <system_error>

namespace sightline::server::metrics {
namespace {

namespace fs = std::filesystem;

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

void add_files(Samples& samples) {
  std::error_code error;
  const fs::directory_iterator files("/proc/self/fd", error);
  if (!error) {
    const auto open = std::distance(begin(files), end(files)) - 1;  // without the iterator's own
    samples.add_gauge("process_open_fds", "Open file descriptors.", static_cast<double>(open));
  }
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0) {
    samples.add_gauge("process_max_fds", "Limit of open file descriptors.",
                      static_cast<double>(limit.rlim_cur));
  }
}

/// The start of the process in seconds since 1970; 0 if the system does not tell.
double start_time() {
  std::ifstream file("/proc/self/stat");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::size_t after_name = text.rfind(')');
  if (after_name == std::string::npos) return 0;
  // The fields after the name begin with the third; the start is the 22nd, in ticks since boot.
  std::istringstream fields(text.substr(after_name + 2));
  std::string skipped;
  for (int field = 3; field < 22; ++field) fields >> skipped;
  double ticks = 0;
  fields >> ticks;
  std::ifstream boot("/proc/stat");
  for (std::string word; boot >> word;) {
    double booted = 0;
    if (word == "btime" && boot >> booted)
      return booted + ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  }
  return 0;
}

}  // namespace

void add_process(Samples& samples) {
  rusage used{};
  if (getrusage(RUSAGE_SELF, &used) == 0) {
    samples.add_counter("process_cpu_seconds_total", "Processor time of user and system.",
                        seconds(used.ru_utime) + seconds(used.ru_stime));
  }
  std::uint64_t size = 0, resident = 0;
  if (std::ifstream("/proc/self/statm") >> size >> resident) {
    const auto page = static_cast<double>(sysconf(_SC_PAGESIZE));
    samples.add_gauge("process_virtual_memory_bytes", "Virtual memory.",
                      static_cast<double>(size) * page);
    samples.add_gauge("process_resident_memory_bytes", "Resident memory.",
                      static_cast<double>(resident) * page);
  }
  add_files(samples);
  static const double kStarted = start_time();
  if (kStarted > 0)
    samples.add_gauge("process_start_time_seconds", "Start, in seconds since 1970.", kStarted);
}

}  // namespace sightline::server::metrics
