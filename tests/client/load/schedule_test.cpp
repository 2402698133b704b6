// When requests are due.
#include "client/load/schedule.h"

#include <gtest/gtest.h>

namespace sightline::client::load {
namespace {

using std::chrono::milliseconds;

TEST(Schedule, OfARateIsEvenAndDoesNotDrift) {
  const Schedule schedule = Schedule::open(300);
  EXPECT_TRUE(schedule.is_open());
  EXPECT_EQ(schedule.due(0), Nanoseconds(0));
  EXPECT_EQ(schedule.due(3), Nanoseconds(milliseconds(10)));
  EXPECT_EQ(schedule.due(300'000'000), Nanoseconds(std::chrono::seconds(1'000'000)));
}

TEST(Schedule, OfAClosedLoopHasNoTimes) {
  EXPECT_FALSE(Schedule::closed().is_open());
  EXPECT_FALSE(Schedule::closed().due(7).has_value());
}

}  // namespace
}  // namespace sightline::client::load
