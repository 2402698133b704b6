// A connection gets no more refusals than its calls may have in flight, in each delay that it is
// told.
#include "server/exec/refusal_pace.h"

#include <gtest/gtest.h>

#include "server/config.h"
#include "server/exec/rpc_status.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::server::exec {
namespace {

using Clock = RefusalPace::Clock;
constexpr int kBurst = 8;
const Clock::time_point kStart{std::chrono::hours(1)};

TEST(RefusalPace, ABurstIsAnsweredAtOnceAndTheRestOverTheDelay) {
  RefusalPace pace(kBurst);
  for (int i = 0; i < kBurst; ++i) EXPECT_EQ(pace.due("a", kStart), kStart);
  for (int i = 1; i <= kBurst; ++i)
    EXPECT_EQ(pace.due("a", kStart), kStart + i * Clock::duration(kRetryDelay) / kBurst);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(pace.due("a", kStart), kStart + kRetryDelay);
  EXPECT_EQ(pace.due("b", kStart), kStart) << "another connection has a pace of its own";
}

TEST(RefusalPace, AClientThatObeysNeverWaits) {
  RefusalPace pace(kBurst);
  for (int round = 0; round < 50; ++round) {
    const auto now = kStart + round * kRetryDelay;
    for (int i = 0; i < kBurst; ++i) EXPECT_EQ(pace.due("a", now), now) << round;
  }
}

TEST(RefusalPace, ForgetsWhoWasNotRefusedLately) {
  RefusalPace pace(kBurst);
  for (int i = 0; i < 10'000; ++i) pace.due(std::to_string(i), kStart + i * kRetryDelay);
  EXPECT_LT(pace.connections(), 200u);
}

struct Refusal final : RefusalPace::Waiting {
  void answer() override { ++answers; }
  int answers = 0;
};

TEST(RefusalPace, StopAnswersAllThatWait) {
  RefusalPace pace(kBurst);
  Refusal first, left, late;
  EXPECT_TRUE(pace.enter(first));
  EXPECT_TRUE(pace.enter(left));
  pace.leave(left);
  pace.stop();
  EXPECT_EQ(first.answers, 1);
  EXPECT_EQ(left.answers, 0);
  EXPECT_FALSE(pace.enter(late));
  pace.leave(first);
}

}  // namespace
}  // namespace sightline::server::exec

namespace sightline::tests {
namespace {

server::ServerConfig with_capacity_for_few_rays() {
  server::ServerConfig config = test_config();
  config.admission.rays = 1000;
  return config;
}

class RefusedTest : public LiveServer {
 protected:
  RefusedTest() : LiveServer(with_capacity_for_few_rays()) {}

  grpc::Status cast(std::size_t rays) {
    v1::CastRaysResponse reply;
    return api_.cast(cast_request(kScene, rays_downward(rays)), &reply);
  }
};

TEST_F(RefusedTest, ComingBackAtOnceIsNoFasterThanWaiting) {
  api_.make_scene(kScene, planar_sheet(1));
  constexpr int kCalls = 2 * server::ServerConfig::kMaxCallsPerConnection;
  const auto begun = std::chrono::steady_clock::now();
  for (int i = 0; i < kCalls; ++i)
    EXPECT_EQ(cast(1001).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_GE(std::chrono::steady_clock::now() - begun, server::exec::kRetryDelay);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(cast(1000).ok()) << "what fits is not delayed";
}

}  // namespace
}  // namespace sightline::tests
