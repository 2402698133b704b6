// What a soak measures in one window of time, and how that changes over all windows.
#include "tests/soak/window.h"

#include <fmt/core.h>

#include <utility>

namespace sightline::tests::soak {

void Latencies::add(std::chrono::duration<double, std::milli> time) {
  const std::lock_guard lock(mutex_);
  ms_.push_back(time.count());
}

std::vector<double> Latencies::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(ms_, {});
}

double slope_per_hour(std::span<const Window> windows, double Window::*figure) {
  const auto count = static_cast<double>(windows.size());
  double mean_x = 0, mean_y = 0;
  for (const Window& window : windows) {
    mean_x += window.seconds / count;
    mean_y += window.*figure / count;
  }
  double xy = 0, xx = 0;
  for (const Window& window : windows) {
    xy += (window.seconds - mean_x) * (window.*figure - mean_y);
    xx += (window.seconds - mean_x) * (window.seconds - mean_x);
  }
  constexpr double kSecondsPerHour = 3600;
  return xx > 0 ? xy / xx * kSecondsPerHour : 0;
}

std::string heading() {
  return fmt::format("{:>9} {:>9} {:>6} {:>8} {:>8} {:>8}", "seconds", "RSS MiB", "files", "calls",
                     "p50 ms", "p99 ms");
}

std::string line_of(const Window& window) {
  return fmt::format("{:>9.0f} {:>9.1f} {:>6.0f} {:>8.0f} {:>8.2f} {:>8.2f}", window.seconds,
                     window.resident_mib, window.files, window.calls, window.p50_ms, window.p99_ms);
}

}  // namespace sightline::tests::soak
