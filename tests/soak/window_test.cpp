// Slopes of known lines.
#include "tests/soak/window.h"

#include <gtest/gtest.h>

namespace sightline::tests::soak {
namespace {

TEST(Window, SlopesAreThoseOfTheLineThroughThem) {
  std::vector<Window> windows;
  for (int i = 0; i < 10; ++i) {
    // Up and down by the same amount, symmetrically.
    const double noise = i % 4 == 0 || i % 4 == 3 ? 1 : -1;
    windows.push_back({.seconds = 60.0 * i, .resident_mib = 100 + 2.0 * i, .files = 20});
    if (i < 8) windows.back().p99_ms = noise;
  }
  EXPECT_NEAR(slope_per_hour(windows, &Window::resident_mib), 120, 1e-9);
  EXPECT_EQ(slope_per_hour(windows, &Window::files), 0);
  EXPECT_NEAR(slope_per_hour(std::span(windows).first(8), &Window::p99_ms), 0, 1e-9);
}

TEST(Latencies, AreTakenOnce) {
  Latencies latencies;
  latencies.add(std::chrono::milliseconds(3));
  EXPECT_EQ(latencies.take(), std::vector<double>{3.0});
  EXPECT_TRUE(latencies.take().empty());
}

}  // namespace
}  // namespace sightline::tests::soak
