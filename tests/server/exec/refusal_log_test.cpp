// The lines of refused calls are bounded, and none is lost in silence.
#include "server/exec/refusal_log.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>

namespace sightline::server::exec {
namespace {

using Clock = RefusalLog::Clock;

TEST(RefusalLog, LogsAFewLinesASecondAndCountsTheRest) {
  const Clock::time_point begin{};
  RefusalLog log(begin);
  for (std::uint64_t i = 0; i < RefusalLog::kLinesPerSecond; ++i)
    EXPECT_EQ(log.count(begin), std::uint64_t{1});
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(log.count(begin));
  EXPECT_EQ(log.count(begin + std::chrono::seconds(1)), std::uint64_t{101});
  EXPECT_EQ(log.count(begin + std::chrono::seconds(1)), std::uint64_t{1});
}

TEST(RefusalLog, AQuietTimeAllowsNoMoreThanASecondOfLines) {
  const Clock::time_point begin{};
  RefusalLog log(begin);
  std::uint64_t lines = 0;
  for (int i = 0; i < 1000; ++i) lines += log.count(begin + std::chrono::hours(1)).has_value();
  EXPECT_EQ(lines, RefusalLog::kLinesPerSecond);
}

}  // namespace
}  // namespace sightline::server::exec
