// Flags that become true at a time.
#include "server/exec/deadlines.h"
#include "tests/support/sleep_shortly.h"

#include <gtest/gtest.h>

#include <vector>

namespace sightline::server::exec {
namespace {

using Clock = Deadlines::Clock;

constexpr Clock::time_point kPast = Clock::time_point::min();
constexpr std::chrono::hours kLong{1};

TEST(Deadlines, SetsAFlagWhoseTimeHasCome) {
  Deadlines deadlines;
  std::atomic<bool> flag{false};
  const Deadlines::Alarm alarm = deadlines.set(kPast, flag);
  while (!flag) tests::sleep_shortly();
}

TEST(Deadlines, LeavesOtherFlags) {
  Deadlines deadlines;
  std::atomic<bool> late{false}, early{false};
  const Deadlines::Alarm later = deadlines.set(Clock::now() + kLong, late);
  const Deadlines::Alarm sooner = deadlines.set(Clock::now(), early);
  while (!early) tests::sleep_shortly();
  EXPECT_FALSE(late);
}

TEST(Deadlines, AnAlarmThatIsGoneTouchesNothing) {
  Deadlines deadlines;
  for (int round = 0; round < 1000; ++round) {
    std::atomic<bool> flag{false};
    Deadlines::Alarm alarm = deadlines.set(Clock::now(), flag);
    alarm = {};
    const bool before = flag;
    tests::sleep_shortly();
    EXPECT_EQ(flag, before);
  }
}

TEST(Deadlines, AnAlarmMayBeReplaced) {
  Deadlines deadlines;
  std::atomic<bool> flag{false};
  Deadlines::Alarm alarm = deadlines.set(Clock::now() + kLong, flag);
  alarm = deadlines.set(kPast, flag);
  while (!flag) tests::sleep_shortly();
}

}  // namespace
}  // namespace sightline::server::exec
