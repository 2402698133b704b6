// A process that does not end by itself is ended.
#include "server/watchdog.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

namespace sightline::server {
namespace {

/// Its end comes from elsewhere.
[[noreturn]] void hang() {
  while (true) pause();
}

TEST(WatchdogDeathTest, EndsAProcessThatHangsAfterItWasArmed) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        auto& watchdog = *new Watchdog;
        watchdog.arm(std::chrono::milliseconds(1));
        hang();
      },
      testing::ExitedWithCode(0), "ended by its watchdog");
}

TEST(WatchdogDeathTest, LetsAProcessEndByItself) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        auto& watchdog = *new Watchdog;
        watchdog.arm(std::chrono::hours(1));
        std::exit(3);
      },
      testing::ExitedWithCode(3), "");
}

}  // namespace
}  // namespace sightline::server
