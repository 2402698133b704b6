// Runs against a target that takes exact times, by a clock that it moves.
#include "client/load/run.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include "tests/client/load/fake_clock.h"

namespace sightline::client::load {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Answers each request after the time that `delay` says.
class TimedTarget final : public Target {
 public:
  using Delay = std::function<Nanoseconds(std::uint64_t request)>;
  TimedTarget(tests::FakeClock& clock, Delay delay) : clock_(clock), delay_(std::move(delay)) {}

  Outcome send(std::size_t, std::uint64_t request, const std::stop_token&) override {
    clock_.advance(delay_(request));
    Outcome outcome;
    outcome.rays = 10;
    outcome.hits = 1;
    return outcome;
  }

 private:
  tests::FakeClock& clock_;
  Delay delay_;
};

Record record_of(const RunOptions& options, const TimedTarget::Delay& delay) {
  tests::FakeClock clock;
  TimedTarget target(clock, delay);
  return run(options, target, clock, {}).record;
}

double ms(const Histogram& latency, double share) {
  return static_cast<double>(latency.quantile(share)) * 1e-6;
}

TEST(LoadRun, OfAKnownDelayMeasuresThatDelay) {
  const auto delay = [](std::uint64_t) { return milliseconds(7); };
  const RunOptions closed{.most = seconds(7)};
  RunOptions open = closed;
  open.schedule = Schedule::open(100);
  for (const RunOptions& options : {closed, open}) {
    const Record record = record_of(options, delay);
    for (const double share : {0.01, 0.5, 0.99, 1.0})
      EXPECT_NEAR(ms(record.latency, share), 7, 7.0 / (1 << (Histogram::kPrecisionBits + 1)));
  }
  EXPECT_EQ(record_of(closed, delay).latency.count(), 1000u);
  EXPECT_EQ(record_of(open, delay).latency.count(), 700u);
}

TEST(LoadRun, AStallIsChargedToAllRequestsThatWereDueMeanwhile) {
  const auto delay = [](std::uint64_t request) {
    return request == 100 ? Nanoseconds(seconds(1)) : Nanoseconds(milliseconds(1));
  };
  RunOptions options{.schedule = Schedule::open(100), .most = seconds(10)};
  const Record open = record_of(options, delay);
  EXPECT_EQ(open.latency.count(), 1000u);
  // A hundred requests were due within that second, and then others until the backlog is gone.
  EXPECT_GT(ms(open.latency, 0.95), 500);
  EXPECT_NEAR(ms(open.latency, 1), 1000, 1);
  EXPECT_NEAR(ms(open.latency, 0.5), 1, 0.01);
  // A closed loop waits politely, and sees one slow request.
  options.schedule = Schedule::closed();
  const Record closed = record_of(options, delay);
  EXPECT_NEAR(ms(closed.latency, 0.999), 1, 0.01);
}

TEST(LoadRun, EndsAfterItsNumberOfRequests) {
  const RunOptions options{.requests = 25, .most = seconds(100)};
  tests::FakeClock clock;
  TimedTarget target(clock, [](std::uint64_t) { return milliseconds(1); });
  const auto ran = run(options, target, clock, {});
  EXPECT_EQ(ran.sent, 25u);
  EXPECT_EQ(ran.record.rays, 250u);
  EXPECT_TRUE(ran.complete);
  EXPECT_EQ(ran.record.end, Nanoseconds(milliseconds(25)));
}

TEST(LoadRun, ThatIsOutOfTimeIsNotComplete) {
  const RunOptions options{.requests = 25, .most = milliseconds(10)};
  tests::FakeClock clock;
  TimedTarget target(clock, [](std::uint64_t) { return milliseconds(1); });
  const auto ran = run(options, target, clock, {});
  EXPECT_EQ(ran.sent, 10u);
  EXPECT_FALSE(ran.complete);
}

TEST(LoadRun, EndsWhenItIsStable) {
  const RunOptions options{.until_stable = true, .most = seconds(100)};
  tests::FakeClock clock;
  // The first second is slower, as caches and trees are.
  TimedTarget target(clock, [](std::uint64_t request) {
    return request < 300 ? milliseconds(3) : milliseconds(2);
  });
  const auto ran = run(options, target, clock, {});
  EXPECT_TRUE(ran.stable);
  EXPECT_LT(ran.record.end, Nanoseconds(seconds(6)));
  EXPECT_GE(ran.record.end, Nanoseconds(seconds(3)));
}

TEST(LoadRun, ARequestedStopEndsIt) {
  std::stop_source stop;
  stop.request_stop();
  tests::FakeClock clock;
  TimedTarget target(clock, [](std::uint64_t) { return milliseconds(1); });
  const auto ran = run({.most = seconds(5)}, target, clock, stop.get_token());
  EXPECT_EQ(ran.sent, 0u);
  EXPECT_EQ(ran.record.failed, 0u);
  EXPECT_FALSE(ran.complete);
}

TEST(LoadRun, WorkersTakeEachRequestOnce) {
  class Counting final : public Target {
   public:
    Outcome send(std::size_t worker, std::uint64_t request, const std::stop_token&) override {
      EXPECT_LT(worker, 4u);
      ++sent.at(request);
      return {};
    }
    std::vector<std::atomic<int>> sent = std::vector<std::atomic<int>>(500);
  };
  Counting target;
  SteadyClock clock;
  const auto ran = run({.workers = 4, .requests = 500}, target, clock, {});
  EXPECT_EQ(ran.record.latency.count(), 500u);
  for (const auto& count : target.sent) EXPECT_EQ(count, 1);
}

TEST(LoadRun, WhatIsNotAnsweredInTimeIsCancelledAndFails) {
  class Hanging final : public Target {
   public:
    explicit Hanging(tests::FakeClock& clock) : clock_(clock) {}
    Outcome send(std::size_t, std::uint64_t, const std::stop_token& stop) override {
      clock_.advance(seconds(3));
      while (!stop.stop_requested()) std::this_thread::yield();
      Outcome outcome;
      outcome.state = Outcome::State::kCancelled;
      return outcome;
    }

   private:
    tests::FakeClock& clock_;
  };
  tests::FakeClock clock;
  Hanging target(clock);
  RunOptions options{.schedule = Schedule::open(10), .most = seconds(1), .drain = seconds(1)};
  EXPECT_EQ(run(options, target, clock, {}).record.failed, 10u) << "those that were due, too";
  options.is_strict = false;
  const auto ran = run(options, target, clock, {});
  EXPECT_EQ(ran.record.failed, 0u);
  EXPECT_FALSE(ran.complete);
}

}  // namespace
}  // namespace sightline::client::load
