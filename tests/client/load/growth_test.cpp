// Samples of a scene that grows.
#include "client/load/growth.h"
#include "tests/support/sleep_shortly.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace sightline::client::load {
namespace {

TEST(Growth, SamplesFromTheBeginningToTheEnd) {
  std::atomic<std::uint64_t> built = 0;
  SteadyClock clock;
  GrowthSampler sampler(
      [&]() -> Result<SceneStats> {
        SceneStats stats;
        stats.triangles_built = ++built;
        stats.bytes_trees = 10 * stats.triangles_built;
        return stats;
      },
      clock, std::chrono::microseconds(10));
  while (built < 3) tests::sleep_shortly();
  const auto samples = sampler.finish();
  ASSERT_GE(samples.size(), 4u);
  EXPECT_EQ(samples.back().triangles_built, built);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].triangles_built, i + 1);
    EXPECT_EQ(samples[i].bytes_trees, 10 * (i + 1));
    EXPECT_GE(samples[i].time, samples[i > 0 ? i - 1 : 0].time);
  }
}

TEST(Growth, AServerThatDoesNotAnswerIsLeftOut) {
  SteadyClock clock;
  GrowthSampler sampler(
      []() -> Result<SceneStats> {
        return Error{Code::kUnavailable, "gone", {}};
      },
      clock, std::chrono::milliseconds(1));
  EXPECT_TRUE(sampler.finish().empty());
}

}  // namespace
}  // namespace sightline::client::load
