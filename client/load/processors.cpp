// Reads times from the system, and judges them.
#include "client/load/processors.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <string>

namespace sightline::client::load {
namespace {

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double own_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// Seconds over all processors, from proc(5): user nice system idle iowait irq softirq ...
double busy_seconds() {
  std::ifstream in("/proc/stat");
  std::string name;
  std::array<double, 7> ticks{};
  in >> name;
  for (double& count : ticks) in >> count;
  if (!in) return 0;
  const double busy = ticks[0] + ticks[1] + ticks[2] + ticks[5] + ticks[6];
  return busy / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

int online_processors() { return static_cast<int>(std::max(::sysconf(_SC_NPROCESSORS_ONLN), 1L)); }

int percent(double share) { return static_cast<int>(std::lround(share * 100)); }

}  // namespace

ProcessorMeter::ProcessorMeter()
    : begin_s_(now_s()), own_s_(own_seconds()), busy_s_(busy_seconds()) {}

ProcessorUse ProcessorMeter::use() const {
  return {.elapsed_s = now_s() - begin_s_,
          .processors = online_processors(),
          .own_s = own_seconds() - own_s_,
          .busy_s = busy_s_ > 0 ? busy_seconds() - busy_s_ : 0};
}

std::string bottleneck(const ProcessorUse& use, double in_flight_s) {
  const int own = percent(use.own_share());
  if (use.own_share() >= kOwnShare)
    return fmt::format("the load test itself takes {} % of this machine's processors", own);
  if (use.busy_share() >= kBusyShare && use.own_share() >= kBusyOwnShare) {
    return fmt::format(
        "this machine is {} % busy, and the load test itself takes {} % of its processors",
        std::min(percent(use.busy_share()), 100), own);
  }
  const bool is_much = use.own_s >= kLeastOwn * use.elapsed_s;
  if (is_much && in_flight_s > 0 && use.own_s >= kFlightShare * in_flight_s) {
    return fmt::format("of the time of requests, {} % is the load test's own work",
                       std::min(percent(use.own_s / in_flight_s), 100));
  }
  return {};
}

}  // namespace sightline::client::load
