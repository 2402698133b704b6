// Which failures of a call are worth another attempt.
#include "client/calls/attempts.h"

#include <gtest/gtest.h>

#include <chrono>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace sightline::client::calls {
namespace {

using std::chrono::milliseconds;

grpc::Status refusal() {
  google::rpc::RetryInfo retry;
  retry.mutable_retry_delay()->set_nanos(1'000'000);
  google::rpc::Status details;
  details.add_details()->PackFrom(retry);
  return {grpc::RESOURCE_EXHAUSTED, "come back later", details.SerializeAsString()};
}

const grpc::Status kBroken(grpc::UNAVAILABLE, "connection reset");

TEST(Attempts, OnlyWhatIsAskedIsRepeated) {
  Attempts once({}, Repeat::kNothing);
  EXPECT_FALSE(once.pause(refusal()));
  EXPECT_FALSE(once.pause(kBroken));
  Attempts refusals({}, Repeat::kRefusals);
  EXPECT_TRUE(refusals.pause(refusal()));
  EXPECT_FALSE(refusals.pause(kBroken));
  Attempts both({}, Repeat::kRefusalsAndBreaks);
  EXPECT_TRUE(both.pause(refusal()));
  EXPECT_TRUE(both.pause(kBroken));
  EXPECT_FALSE(both.pause({grpc::NOT_FOUND, ""}));
}

TEST(Attempts, ConnectionsMayBreakThreeTimes) {
  Attempts attempts({}, Repeat::kRefusalsAndBreaks);
  milliseconds last{0};
  for (int i = 0; i < 3; ++i) {
    const auto pause = attempts.pause(kBroken);
    ASSERT_TRUE(pause);
    EXPECT_GT(*pause, last);
    last = *pause;
  }
  EXPECT_FALSE(attempts.pause(kBroken));
}

TEST(Attempts, ABrokenConnectionBeginsTheDeadlineAnew) {
  EXPECT_FALSE(Attempts({}, Repeat::kRefusals).deadline());
  Attempts attempts(milliseconds(60'000), Repeat::kRefusalsAndBreaks);
  const auto first = *attempts.deadline();
  ASSERT_TRUE(attempts.pause(refusal()));
  EXPECT_EQ(*attempts.deadline(), first);
  const auto pause = attempts.pause(kBroken);
  ASSERT_TRUE(pause);
  EXPECT_GE(*attempts.deadline(), first + *pause);
}

}  // namespace
}  // namespace sightline::client::calls
