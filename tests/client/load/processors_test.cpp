// When the load test suspects itself.
#include "client/load/processors.h"

#include <gtest/gtest.h>

namespace sightline::client::load {
namespace {

ProcessorUse use_of(double own_share, double busy_share) {
  return {.elapsed_s = 10, .processors = 4, .own_s = 40 * own_share, .busy_s = 40 * busy_share};
}

constexpr double kMuchFlight = 1000;

TEST(Processors, ALightLoadTestIsNotSuspect) {
  EXPECT_EQ(bottleneck(use_of(0.1, 1.0), kMuchFlight), "");
  EXPECT_EQ(bottleneck(use_of(0.3, 0.7), kMuchFlight), "");
}

TEST(Processors, HalfOfTheMachineIs) {
  EXPECT_NE(bottleneck(use_of(0.55, 0.6), kMuchFlight).find("55 %"), std::string::npos);
}

TEST(Processors, AQuarterIsOnAMachineWithoutTimeLeft) {
  EXPECT_NE(bottleneck(use_of(0.3, 1.0), kMuchFlight).find("30 %"), std::string::npos);
}

TEST(Processors, SoAreRequestsThatAreMostlyItsOwnWork) {
  EXPECT_NE(bottleneck(use_of(0.1, 0.2), 6), "");
  EXPECT_EQ(bottleneck(use_of(0.1, 0.2), 20), "");
}

TEST(Processors, ALoadTestThatIsNearlyIdleIsNot) {
  for (const double own : {0.0, 0.001, 0.014, 0.03, 0.06}) {
    for (const double in_flight : {0.01, 0.5, 1.0})
      EXPECT_EQ(bottleneck(use_of(own, 0.2), in_flight), "") << own;
  }
  EXPECT_EQ(bottleneck({.elapsed_s = 30, .processors = 2, .own_s = 0.84, .busy_s = 58}, 0.9), "");
}

TEST(Processors, TheMeterCountsThisProcess) {
  const ProcessorMeter meter;
  while (meter.use().own_s < 0.02) {
  }
  const ProcessorUse use = meter.use();
  EXPECT_GE(use.processors, 1);
  EXPECT_GT(use.elapsed_s, 0);
  EXPECT_GT(use.own_share(), 0);
}

}  // namespace
}  // namespace sightline::client::load
