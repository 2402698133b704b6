// What a soak measures in one window of time, and how that changes over all windows.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace sightline::tests::soak {

/// Times of calls. Threads: any.
class Latencies {
 public:
  void add(std::chrono::duration<double, std::milli> time);
  /// The times since the last call of this, in ms.
  std::vector<double> take();

 private:
  std::mutex mutex_;
  std::vector<double> ms_;
};

struct Window {
  double seconds = 0;  ///< From the beginning to the end of the window.
  double resident_mib = 0;
  double files = 0;
  double calls = 0;
  double p50_ms = 0, p99_ms = 0;
};

/// Change per hour of a straight line through the windows, by least squares. At least two windows.
double slope_per_hour(std::span<const Window> windows, double Window::*figure);

/// One line a window, without an end of line; the first is the heading.
std::string heading();
std::string line_of(const Window& window);

}  // namespace sightline::tests::soak
