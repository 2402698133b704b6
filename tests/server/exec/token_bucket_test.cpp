// A limit on how fast something is used.
#include "server/exec/token_bucket.h"

#include <gtest/gtest.h>

namespace sightline::server::exec {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr TokenBucket::Clock::time_point kFilled{};

TEST(TokenBucket, GivesABurstOfOneSecondAtOnce) {
  TokenBucket bucket(100, kFilled);
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(bucket.open(kFilled)) << i;
    bucket.take(10);
  }
  EXPECT_FALSE(bucket.open(kFilled));
  EXPECT_TRUE(bucket.open(kFilled + milliseconds(1)));
}

TEST(TokenBucket, ALargeAmountIsPaidLater) {
  TokenBucket bucket(100, kFilled);
  bucket.take(1100);
  EXPECT_FALSE(bucket.open(kFilled));
  EXPECT_FALSE(bucket.open(kFilled + seconds(10)));
  EXPECT_TRUE(bucket.open(kFilled + seconds(10) + milliseconds(1)));
}

TEST(TokenBucket, SaysWhenItOpens) {
  TokenBucket bucket(100, kFilled);
  EXPECT_EQ(bucket.wait(kFilled), milliseconds(0));
  bucket.take(350);
  const auto wait = bucket.wait(kFilled);
  EXPECT_GE(wait, milliseconds(2500));
  EXPECT_LE(wait, milliseconds(2502));
  EXPECT_TRUE(bucket.open(kFilled + wait));
}

TEST(TokenBucket, HoldsItsRateInTheLongRun) {
  TokenBucket bucket(1000, kFilled);
  std::uint64_t taken = 0;
  for (int ms = 0; ms < 100'000; ++ms) {
    if (!bucket.open(kFilled + milliseconds(ms))) continue;
    bucket.take(77);
    taken += 77;
  }
  EXPECT_NEAR(static_cast<double>(taken), 101'000, 77);
}

TEST(TokenBucket, AnIdleOneKeepsNoMoreThanOneSecond) {
  TokenBucket bucket(10, kFilled);
  EXPECT_TRUE(bucket.full(kFilled));
  bucket.take(1);
  EXPECT_FALSE(bucket.full(kFilled));
  EXPECT_TRUE(bucket.full(kFilled + seconds(100)));
  bucket.take(10);
  EXPECT_FALSE(bucket.open(kFilled + seconds(100)));
}

}  // namespace
}  // namespace sightline::server::exec
