// Which refusals are repeated, when, and for how long.
#include "client/calls/retries.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace sightline::client::calls {
namespace {

using std::chrono::milliseconds;

grpc::Status refusal(milliseconds delay, grpc::StatusCode code = grpc::RESOURCE_EXHAUSTED) {
  google::rpc::ErrorInfo info;
  info.set_reason("QUEUE_FULL");
  google::rpc::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(delay.count() / 1000);
  retry.mutable_retry_delay()->set_nanos(static_cast<int>(delay.count() % 1000) * 1'000'000);
  google::rpc::Status details;
  details.add_details()->PackFrom(info);
  details.add_details()->PackFrom(retry);
  return {code, "come back later", details.SerializeAsString()};
}

TEST(Retries, TheServerSaysWhen) {
  EXPECT_EQ(retry_delay(refusal(milliseconds(1250))), milliseconds(1250));
  Retries retries;
  for (int i = 0; i < 3; ++i) {
    const auto pause = retries.pause(refusal(milliseconds(1000)));
    ASSERT_TRUE(pause);
    EXPECT_GE(*pause, milliseconds(1000));
    EXPECT_LE(*pause, milliseconds(1500));
  }
}

TEST(Retries, OtherErrorsAreNotRepeated) {
  Retries retries;
  EXPECT_FALSE(retries.pause(grpc::Status::OK));
  EXPECT_FALSE(retries.pause({grpc::RESOURCE_EXHAUSTED, "too large"}));
  EXPECT_FALSE(retries.pause({grpc::RESOURCE_EXHAUSTED, "too large", "no message"}));
  EXPECT_FALSE(retries.pause(refusal(milliseconds(1), grpc::UNAVAILABLE)));
  EXPECT_FALSE(retries.wait({grpc::INVALID_ARGUMENT, ""}, {}));
}

TEST(Retries, PausesGrowAndEnd) {
  Retries retries;
  milliseconds longest{0}, sum{0};
  int pauses = 0;
  while (const auto pause = retries.pause(refusal(milliseconds(1000)))) {
    longest = std::max(longest, *pause);
    sum += *pause;
    ++pauses;
  }
  EXPECT_GT(longest, milliseconds(8000) - milliseconds(1));
  EXPECT_LE(longest, milliseconds(12'000));
  EXPECT_LE(sum, milliseconds(60'000));
  EXPECT_GT(pauses, 5);
  retries.progressed();
  EXPECT_LE(retries.pause(refusal(milliseconds(1000))).value_or(longest), milliseconds(1500));
}

TEST(Retries, ADeadlineIsNotSleptThrough) {
  const auto soon = std::chrono::system_clock::now() + milliseconds(20'000);
  Retries retries(soon);
  EXPECT_TRUE(retries.pause(refusal(milliseconds(1))));
  EXPECT_FALSE(retries.wait(refusal(milliseconds(30'000)), {}));
}

TEST(Retries, AStopEndsThePause) {
  std::stop_source stop;
  stop.request_stop();
  Retries retries;
  EXPECT_FALSE(retries.wait(refusal(milliseconds(30'000)), stop.get_token()));
  EXPECT_TRUE(retries.wait(refusal(milliseconds(1)), {}));
}

}  // namespace
}  // namespace sightline::client::calls
